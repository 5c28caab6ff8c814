"""Hand and mount descriptions: what a robot has (contacts, joints, joint sets), without any simulator.

A hand is a YAML file beside its URDF. Everything the checker, the compiler and the worlds know about a hand stands
there, so that nothing in the code knows the Barrett hand.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from functools import cache
from pathlib import Path
from typing import Annotated, Self
from xml.etree import ElementTree

import yaml
from pydantic import AfterValidator, Field, PrivateAttr, model_validator

from graspdsl.hands.fingertips import Angles, CapsuleTip, EllipsoidTip, FingertipShape, Place, SphereTip
from graspdsl.places.fields import Count, Metres, Model, Number
from graspdsl.spec.models import folder_name

HERE = Path(__file__).parent
ALL = "all"  # the set of all joints of a robot
MOUNTING = "mounting"  # the joint between its mount and its hand

JointNames = Annotated[tuple[str, ...], Field(min_length=1)]


class Joint(Model):
    """An actuated joint. ``weight`` [m or rad per m] scales it in gradient space: about one over its lever."""

    weight: Number = Field(gt=0.0, le=1000.0)
    closes: Count = Field(0, ge=-1, le=1, description="sign of the motion that closes the hand; 0: it does not")


class Coupling(Model):
    """A joint that follows an actuated one: angle = ratio · angle of ``follows``."""

    follows: str
    ratio: Number = Field(ge=-100.0, le=100.0)


class Contact(Model):
    """A fingertip: its link, the load cell's fixed joint before it, its one shape.

    A contact of a hand without a model has none of these.
    """

    link: str = ""
    cell: str = ""
    sphere: SphereTip | None = None
    ellipsoid: EllipsoidTip | None = None
    capsule: CapsuleTip | None = None
    finger: tuple[str, ...] = Field(
        (), min_length=1, description="the joints of its own finger, which open and close it"
    )

    @model_validator(mode="after")
    def _one_shape(self) -> Contact:
        shapes = [shape for shape in (self.sphere, self.ellipsoid, self.capsule) if shape is not None]
        if len(shapes) != bool(self.link):
            raise ValueError("a fingertip with a link has exactly one shape: sphere, ellipsoid or capsule")
        return self

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


class Hand(Described):
    """A hand description file. Without a ``urdf`` it is bare contacts, for the floating world."""

    hand: Annotated[str, AfterValidator(folder_name)]
    about: str = Field("", max_length=1000)
    mjcf: str = Field("", max_length=1000)
    root: str = ""
    palm: str = ""
    palm_surface: Metres = Field(0.0, ge=-1.0, le=1.0, description="m ahead of the mounting face, along its z axis")
    joints: dict[str, Joint] = Field(default={})
    couplings: dict[str, Coupling] = Field(default={})
    contacts: dict[str, Contact] = Field(min_length=1)
    joint_sets: dict[str, JointNames] = Field(default={})
    postures: dict[str, dict[str, Number]] = Field(default={})


class Base(Model):
    """Where an arm stands in the world: the pose of its URDF's root, position [m] and fixed-axis angles [rad]."""

    position: Place = (0.0, 0.0, 0.0)
    rpy: Angles = (0.0, 0.0, 0.0)


class Mount(Described):
    """A mount description file: what carries the hand.

    With a ``base`` it is an arm that stands there and reaches for the start pose. Without, its root stands wherever a
    trial starts, all its joints at zero.
    """

    mount: Annotated[str, AfterValidator(folder_name)]
    about: str = Field("", max_length=1000)
    urdf: str = Field(min_length=1, max_length=1000)
    face: str
    base: Base | None = None
    joints: dict[str, Joint]
    joint_sets: dict[str, JointNames] = Field(default={})


class Robot(Model):
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


def _catalogue(kind: str) -> Iterator[tuple[str, object]]:
    for path in sorted(HERE.glob("*.yaml")):
        document = yaml.safe_load(path.read_text("utf-8"))
        if kind in document:
            yield document[kind], document


@cache
def hands() -> dict[str, Hand]:
    """The catalogue of hands, by name; those of ``hands_in`` can be added to it."""
    return {name: Hand.model_validate(document) for name, document in _catalogue("hand")}


@cache
def mounts() -> dict[str, Mount]:
    """The catalogue of mounts, by name; those of ``mounts_in`` can be added to it."""
    return {name: Mount.model_validate(document) for name, document in _catalogue("mount")}


def joint_limits(robot: Robot) -> tuple[tuple[float, ...], tuple[float, ...]]:
    """Lower and upper limits [m or rad] of a robot's joints in command order, as its URDFs say."""
    limits = {name: joint.find("limit") for name, joint in _joints_in(robot).items()}
    found = [limit for name in robot.joints if (limit := limits[name]) is not None]
    return tuple(float(f.get("lower", "0")) for f in found), tuple(float(f.get("upper", "0")) for f in found)


def joint_units(robot: Robot) -> dict[str, str]:
    """The units of a robot's joints in command order, as its URDFs say: m for a slide, else rad."""
    slides = {name for name, joint in _joints_in(robot).items() if joint.get("type") == "prismatic"}
    return {name: "m" if name in slides else "rad" for name in robot.joints}


def _joints_in(robot: Robot) -> dict[str, ElementTree.Element]:
    models = map(ElementTree.fromstring, robot.models)
    return {joint.get("name", ""): joint for model in models for joint in model.iter("joint")}


@cache
def robot(hand: str, mount: str) -> Robot:
    """The named hand on the named mount. Raises KeyError for a name that is not in the catalogue."""
    return Robot(hand=hands()[hand], mount=mounts()[mount])
