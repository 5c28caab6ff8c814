"""Hand and mount descriptions: what a robot has (contacts, joints, joint sets), without any simulator.

A hand is a YAML file beside its URDF. Everything the checker, the compiler and the worlds know about a hand stands
there, so that nothing in the code knows the Barrett hand.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache, lru_cache
from pathlib import Path
from typing import Annotated, Self, TypeVar
from xml.etree import ElementTree

import numpy as np
from pydantic import VERSION, AfterValidator, Field, PrivateAttr, model_validator

from graspdsl.angles import turned_by_angles
from graspdsl.arrays import Array
from graspdsl.hands.fingertips import Angles, CapsuleTip, Directed, EllipsoidTip, FingertipShape, Place, SphereTip
from graspdsl.places.data_files import data_in
from graspdsl.places.fields import Count, Metres, Model, Number, fault
from graspdsl.places.kept import kept
from graspdsl.spec.models import folder_name

HERE = Path(__file__).parent
ALL = "all"  # the set of all joints of a robot
UP = (0.0, 0.0, 1.0)
MOUNTING = "mounting"  # the joint between its mount and its hand

JointNames = Annotated[tuple[str, ...], Field(min_length=1)]


class Joint(Model):
    """An actuated joint. ``weight`` [m or rad per m] scales it in gradient space: about one over its lever."""

    weight: Number = Field(gt=0.0, le=1000.0)
    closes: Count = Field(0, ge=-1, le=1, description="sign of the motion that closes the hand; 0: it does not")


class Coupling(Model):
    """A joint that follows an actuated one: place = ratio · place of ``follows`` + offset [rad or m]."""

    follows: str
    ratio: Number = Field(ge=-100.0, le=100.0)
    offset: Number = Field(0.0, ge=-100.0, le=100.0)


class Contact(Model):
    """A fingertip: its link, the load cell's fixed joint before it, its one shape; or the link that it is put ``onto``,
    in place of what of that touches, behind a load cell of its own.

    A contact of a hand without a model has none of these.
    """

    link: str = ""
    cell: str = ""
    onto: str = ""
    sphere: SphereTip | None = None
    ellipsoid: EllipsoidTip | None = None
    capsule: CapsuleTip | None = None
    finger: tuple[str, ...] = Field(
        (), min_length=1, description="the joints of its own finger, which open and close it"
    )

    @model_validator(mode="after")
    def _one_shape(self) -> Contact:
        shapes = [shape for shape in (self.sphere, self.ellipsoid, self.capsule) if shape is not None]
        if self.onto and (self.link or self.cell):
            message = "a fingertip is a link of the model, or is put onto one"
            raise fault("wrong-form", message, "keep link and cell, or onto")
        if shapes and not self.host:
            message = "the fingertip has a shape and no link"
            raise fault("missing-key", message, "name link and cell, or the link that it is put onto, by onto")
        if len(shapes) != bool(self.host):
            message = f"a fingertip has exactly one shape: sphere, ellipsoid or capsule, found {len(shapes)}"
            raise fault("wrong-form", message, "for example sphere: {centre: [0.0, 0.0, 0.0], radius: 0.01}")
        return self

    @property
    def host(self) -> str:
        """The link of the model that the fingertip is, or is put onto."""
        return self.link or self.onto

    @property
    def shape(self) -> FingertipShape:
        """The fingertip's shape. Raises ValueError for a contact without a model."""
        shape = self.sphere or self.ellipsoid or self.capsule
        if shape is None:
            raise ValueError("a bare contact has no fingertip")
        return shape


class Described(Model):
    """A description file beside its URDF: one of this package, or of elsewhere, which then brings its model's text."""

    urdf: str = Field("", max_length=1000)

    _model: str = PrivateAttr("")

    @property
    def model(self) -> str:
        """The text of its URDF, meshes named by where they are; empty for what has none."""
        return self._model or (_model(self.urdf) if self.urdf else "")

    def with_model(self, text: str) -> Self:
        """The same, its URDF of this text."""
        carrying = self.model_copy()
        carrying._model = text
        return carrying


D = TypeVar("D", bound=Described)


class Hand(Described):
    """A hand description file. Without a ``urdf`` it is bare contacts, for the floating world."""

    hand: Annotated[str, AfterValidator(folder_name)]
    about: str = Field("", max_length=1000)
    mjcf: str = Field("", max_length=1000)
    root: str = ""
    palm: str = ""
    palm_normal: Directed = Field(UP, description="where the palm faces, in the frame of the root")
    palm_across: Directed | None = Field(None, description="laid along an object's axis, from finger to finger")
    palm_centre: Place = Field((0.0, 0.0, 0.0), description="m, in the frame of the root: faces an object")
    palm_surface: Metres = Field(0.0, ge=-1.0, le=1.0, description="m from the palm's centre, along its normal")
    joints: dict[str, Joint] = Field(default={})
    couplings: dict[str, Coupling] = Field(default={})
    contacts: dict[str, Contact] = Field(min_length=1)
    joint_sets: dict[str, JointNames] = Field(default={})
    postures: dict[str, dict[str, Number]] = Field(default={})

    @model_validator(mode="after")
    def _two_directions(self) -> Hand:
        if self.palm_across is not None:
            between = np.cross(self.palm_normal, self.palm_across)
            if np.linalg.norm(between) < 1e-3 * np.linalg.norm(self.palm_normal) * np.linalg.norm(self.palm_across):
                hint = "name the direction in which its fingers are side by side"
                raise fault("zero-axis", "palm_across is along the palm's normal", hint)
        return self


class Pose(Model):
    """A pose in another frame: position [m] and fixed-axis angles [rad]."""

    position: Place = (0.0, 0.0, 0.0)
    rpy: Angles = (0.0, 0.0, 0.0)


class Mount(Described):
    """A mount description file: what carries the hand.

    With a ``base``, the pose of its root in the world, it is an arm that stands there and reaches for the start pose.
    Without, its root stands wherever a trial starts, all its joints at zero. ``face``: the link that the hand is fixed
    to, or one with the face at the pose ``face_at``. ``still``: joints of the model that keep where they are [rad or
    m]. ``holds``: the link, that no joint moves, on which an object stands instead of on a table, or one with that
    place at the pose ``holds_at``; the place is the origin of the world, z up.
    """

    mount: Annotated[str, AfterValidator(folder_name)]
    about: str = Field("", max_length=1000)
    mjcf: str = Field("", max_length=1000)
    face: str = ""
    face_at: Pose | None = None
    base: Pose | None = None
    joints: dict[str, Joint] = Field(default={})
    still: dict[str, Number] = Field(default={})
    joint_sets: dict[str, JointNames] = Field(default={})
    holds: str = ""
    holds_at: Pose | None = None


@dataclass(frozen=True)
class Robot:
    """A hand on a mount: the joints of both in command order, mount first."""

    hand: Hand
    mount: Mount

    @property
    def has_model(self) -> bool:
        """Whether the hand is more than bare contacts."""
        return bool(self.hand.urdf)

    @property
    def models(self) -> tuple[str, ...]:
        """The texts of the URDFs of mount and hand; a hand of bare contacts has none."""
        return tuple(filter(None, (self.mount.model, self.hand.model)))

    @property
    def joints(self) -> Mapping[str, Joint]:
        """Actuated joints in command order."""
        return {**self.mount.joints, **self.hand.joints}

    @property
    def joint_sets(self) -> Mapping[str, tuple[str, ...]]:
        """Named joint sets of the mount and the hand, each single joint, and all."""
        single = {name: (name,) for name in self.joints}
        return {**single, **self.mount.joint_sets, **self.hand.joint_sets, ALL: tuple(self.joints)}

    @property
    def contacts(self) -> tuple[str, ...]:
        """Contact names in sensing order."""
        return tuple(self.hand.contacts)

    @property
    def weights(self) -> tuple[float, ...]:
        """The joints' weights in command order."""
        return tuple(joint.weight for joint in self.joints.values())


@cache
def _model(file: str) -> str:
    """The text of a URDF, meshes named by where they are beside it."""
    tree = ElementTree.parse(HERE / file).getroot()
    for mesh in tree.iter("mesh"):
        mesh.set("filename", str((HERE / file).parent / mesh.get("filename", "")))
    return ElementTree.tostring(tree, encoding="unicode")


def _catalogue(kind: str, model: type[D]) -> dict[str, D]:
    documents = (data_in(path) for path in sorted(HERE.glob("*.yaml")))
    return {document[kind]: model.model_validate(document) for document in documents if kind in document}


@cache
def hands() -> dict[str, Hand]:
    """The catalogue of hands, by name; those of ``hands_in`` can be added to it."""
    return kept("hands", VERSION, lambda: _catalogue("hand", Hand))


@cache
def mounts() -> dict[str, Mount]:
    """The catalogue of mounts, by name; those of ``mounts_in`` can be added to it."""
    return kept("mounts", VERSION, lambda: _catalogue("mount", Mount))


def base_pose(mount: Mount) -> tuple[Array, Array]:
    """Where the root of an arm stands: position (3,) [m] and rotation (3, 3). One without a base is at the origin."""
    base = mount.base or Pose()
    return np.array(base.position), turned_by_angles(base.rpy)


def joint_limits(robot: Robot) -> tuple[tuple[float, ...], tuple[float, ...]]:
    """Lower and upper limits [m or rad] of a robot's joints in command order, as its URDFs say."""
    limits = {name: joint.find("limit") for name, joint in _joints_in(robot).items()}
    found = [limit for name in robot.joints if (limit := limits[name]) is not None]
    return tuple(float(f.get("lower", "0")) for f in found), tuple(float(f.get("upper", "0")) for f in found)


def joint_units(robot: Robot) -> dict[str, str]:
    """The units of a robot's joints in command order, as its URDFs say: m for a slide, else rad."""
    slides = {name for name, joint in _joints_in(robot).items() if joint.get("type") == "prismatic"}
    return {name: "m" if name in slides else "rad" for name in robot.joints}


def coupling_of(robot: Robot, moving: Sequence[str]) -> Array:
    """(m, n): where all m joints that move are, out of where the n driven ones are in command order."""
    order = {name: column for column, name in enumerate(robot.joints)}
    coupling = np.zeros((len(moving), len(order)))
    for row, name in enumerate(moving):
        coupled = robot.hand.couplings.get(name)
        coupling[row, order[coupled.follows if coupled else name]] = coupled.ratio if coupled else 1.0
    return coupling


def _joints_in(robot: Robot) -> dict[str, ElementTree.Element]:
    return {name: joint for model in robot.models for name, joint in _joints_of(model).items()}


@lru_cache(maxsize=32)
def _joints_of(model: str) -> Mapping[str, ElementTree.Element]:
    """The joints in the text of a URDF; a check of a spec asks for them many times."""
    return {joint.get("name", ""): joint for joint in ElementTree.fromstring(model).iter("joint")}


@cache
def robot(hand: str, mount: str) -> Robot:
    """The named hand on the named mount. Raises KeyError for a name that is not in the catalogue."""
    return Robot(hand=hands()[hand], mount=mounts()[mount])
