"""A model as it was read: links with their solids and masses, the joints between them, one root."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from graspdsl.arrays import Array
from graspdsl.diagnostics import Diagnostic
from graspdsl.models.joint_kinds import FIXED, ROTATING

UNSTATED_EFFORT = 50.0  # N or N m: the most that drives a joint whose model says nothing of it
PORTION = 32  # directions in which all corners of a mesh are looked at together


class Frame(NamedTuple):
    """A frame in another: its origin (3,) [m] and its rotation (3, 3)."""

    place: Array
    rotation: Array

    def then(self, inner: Frame) -> Frame:
        """A frame given in this one."""
        return Frame(self.place + self.rotation @ inner.place, self.rotation @ inner.rotation)

    def inverse(self) -> Frame:
        """The frame that this one is given in, in this one."""
        return Frame(-self.rotation.T @ self.place, self.rotation.T)


HERE = Frame(np.zeros(3), np.eye(3))


@dataclass(frozen=True, slots=True)
class Mesh:
    """A file of triangles at its place on this machine: the scale of its units, and its triangles, scaled, where they
    were read: corners (v, 3) [m] and faces (f, 3). What is only drawn need not be, where something else of the link
    touches: a small body stands for it."""

    place: str
    scale: tuple[float, float, float]
    corners: Array
    faces: npt.NDArray[np.int64]


@dataclass(frozen=True, slots=True)
class Solid:
    """A piece of a link's geometry: ``box`` (three edges), ``sphere`` (radius), ``cylinder`` or ``capsule`` along z
    (radius and length between its ends or between the centres of its balls), ``ellipsoid`` (three semi-axes) or
    ``mesh``, sizes in m; whether it touches and is drawn; its colour; where in the file it stands."""

    kind: str
    sizes: tuple[float, ...]
    frame: Frame
    touches: bool
    seen: bool
    colour: tuple[float, ...] | None
    where: str
    mesh: Mesh | None = None

    def reach(self, directions: Array) -> Array:
        """How far (d,) [m] it reaches along unit directions (d, 3), max n · p over it, all in the frame of its link."""
        along = directions @ self.frame.rotation
        match self.kind, self.sizes:
            case "box", sizes:
                reached = np.abs(along) @ np.array(sizes) / 2.0
            case "sphere", (radius,):
                reached = np.full(len(along), radius)
            case "ellipsoid", sizes:
                reached = np.linalg.norm(along * sizes, axis=1)
            case "cylinder", (radius, length):
                reached = length / 2.0 * np.abs(along[:, 2]) + radius * np.hypot(along[:, 0], along[:, 1])
            case "capsule", (radius, length):
                reached = length / 2.0 * np.abs(along[:, 2]) + radius
            case _:
                assert self.mesh is not None
                corners = np.unique(self.mesh.corners, axis=0)
                portions = np.array_split(along, max(1, len(along) // PORTION))  # all at once take much memory
                reached = np.concatenate([(some @ corners.T).max(axis=1) for some in portions])
        return np.asarray(directions @ self.frame.place + reached)


@dataclass(frozen=True, slots=True)
class Link:
    """A rigid body: its mass [kg], its centre of mass (3,) [m], its inertia (3, 3) [kg m²] about that, along the axes
    of the link, and its solids."""

    mass: float
    centre: Array
    inertia: Array
    solids: tuple[Solid, ...]
    where: str


@dataclass(frozen=True, slots=True)
class Mimic:
    """A joint that follows another: its place = multiplier · place of ``joint`` + offset."""

    joint: str
    multiplier: float
    offset: float


@dataclass(frozen=True, slots=True)
class Joint:
    """A joint: its kind, the links it joins, the frame of its child in that of its parent where it is at 0, its unit
    axis in the child's frame, its limits [rad or m], None where it has none, what drives it at most [N m or N], 0 where
    that is not said, its damping and dry friction, and the joint that it follows.

    A joint whose limits are equal is fixed there.
    """

    kind: str
    parent: str
    child: str
    frame: Frame
    axis: Array
    limits: tuple[float, float] | None
    effort: float
    damping: float
    friction: float
    where: str
    mimic: Mimic | None = None

    def at(self, place: float) -> Frame:
        """The frame of its child in that of its parent where it is at a place [rad or m]."""
        turns, move = self.kind in ROTATING, place * self.axis
        return self.frame.then(Frame(np.zeros(3) if turns else move, _turned(move) if turns else np.eye(3)))

    def held(self, place: float) -> Joint:
        """The same joint, fixed at a place [rad or m]."""
        return replace(self, kind=FIXED, frame=self.at(place), axis=np.zeros(3), limits=(place, place), mimic=None)


def _turned(move: Array) -> Array:
    """The rotation (3, 3) about and by a vector (3,) [rad]."""
    from scipy.spatial.transform import Rotation  # which takes its time to import

    return np.asarray(Rotation.from_rotvec(move).as_matrix())


@dataclass(frozen=True, slots=True)
class Model:
    """Links and joints by name, parents before children, the root, and what is doubtful about the file."""

    root: str
    links: Mapping[str, Link]
    joints: Mapping[str, Joint]
    warnings: tuple[Diagnostic, ...] = ()

    def movers(self, link: str) -> tuple[str, ...]:
        """The joints from the root to a link, the first one first."""
        before = {joint.child: name for name, joint in self.joints.items()}
        chain = []
        while link in before:
            chain.append(before[link])
            link = self.joints[before[link]].parent
        return tuple(reversed(chain))

    def below(self, root: str) -> frozenset[str]:
        """A link and all that hang on it."""
        found = {root}
        for joint in self.joints.values():
            if joint.parent in found:
                found.add(joint.child)
        return frozenset(found)

    def origin_of_motion(self, name: str) -> Mimic:
        """The joint that a joint follows in the end, by its mimicry and that of those it follows: itself when it has
        none."""
        whole = Mimic(name, 1.0, 0.0)
        for mimic in self._mimics(name):
            offset = whole.multiplier * mimic.offset + whole.offset
            whole = Mimic(mimic.joint, whole.multiplier * mimic.multiplier, offset)
        return whole

    def _mimics(self, name: str) -> Iterator[Mimic]:
        while (joint := self.joints.get(name)) is not None and joint.mimic is not None:
            yield joint.mimic
            name = joint.mimic.joint
