"""What each joint of a tree moves: the articulated inertia about or along its axis (Featherstone, all joints free)."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from xml.etree import ElementTree

import numpy as np

from graspdsl.arrays import Array
from graspdsl.basis.algebra import skew
from graspdsl.basis.rotations import exponential

ORIGIN = {"xyz": "0 0 0", "rpy": "0 0 0"}
MOMENTS = ("ixx", "iyy", "izz", "ixy", "ixz", "iyz")


@dataclass(frozen=True, slots=True)
class FrameJoint:
    """A joint: the links it joins, where its child's frame is in its parent's, and its axis (6,) there: the unit turn
    about it, then the unit shift along it; zero of a fixed one."""

    parent: str
    child: str
    place: Array
    rotation: Array
    axis: Array


@dataclass(frozen=True, slots=True)
class Driven:
    """What a joint moves [kg m² or kg]: the articulated inertia about or along its axis; and, with all joints behind it
    held, the greatest about any axis through its place, or the mass."""

    articulated: float
    greatest: float


def pose_of(element: ElementTree.Element) -> tuple[Array, Array]:
    """The place (3,) [m] and the rotation (3, 3) of the <origin> in a checked element."""
    origin = element.find("origin")
    numbers = ORIGIN if origin is None else {**ORIGIN, **origin.attrib}
    place, (roll, pitch, yaw) = (np.array(numbers[key].split(), dtype=float) for key in ORIGIN)
    turns = np.diag([roll, pitch, yaw])
    rotation: Array = exponential(turns[2]) @ exponential(turns[1]) @ exponential(turns[0])
    return place, rotation


def axis_of(joint: ElementTree.Element) -> Array:
    """The axis (3,) of a checked joint, in its own frame."""
    axis = joint.find("axis")
    return np.array(["1", "0", "0"] if axis is None else axis.get("xyz", "").split(), dtype=float)


def inertia_tensor(link: ElementTree.Element) -> Array:
    """The moments and products of inertia (3, 3) [kg m²] of a checked link, about its centre of mass."""
    element = link.find("inertial/inertia")
    if element is None:
        return np.zeros((3, 3))
    xx, yy, zz, xy, xz, yz = (float(element.get(key, "0")) for key in MOMENTS)
    return np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])


def mass_of(link: ElementTree.Element) -> float:
    """The mass [kg] of a checked link, zero of one that says nothing of it."""
    mass = link.find("inertial/mass")
    return 0.0 if mass is None else float(mass.get("value", "0"))


def driven_inertias(
    links: Mapping[str, ElementTree.Element], joints: Mapping[str, FrameJoint], root: str
) -> dict[str, Driven]:
    """What each joint that moves drives with all joints at zero: D = sᵀ I s, where I (6, 6) is the articulated inertia
    of its child and s its axis (Featherstone 2008, eq. 7.27). A dynamics engine holds a joint still whose D is zero.
    """
    found = {}
    free = {name: _spatial_inertia(link) for name, link in links.items()}
    rigid = {name: inertia.copy() for name, inertia in free.items()}
    for name, joint in _leaves_first(joints, root):
        inertia, axis = free[joint.child], joint.axis
        if axis.any():
            pushed = inertia @ axis
            moved = float(axis @ pushed)
            held = rigid[joint.child]
            greatest = np.linalg.eigvalsh(held[:3, :3])[-1] if axis[:3].any() else held[5, 5]
            found[name] = Driven(moved, float(greatest))
            if moved > 0.0:
                inertia = inertia - np.outer(pushed, pushed) / moved
        down = _motion_transform(joint.place, joint.rotation)
        free[joint.parent] += down.T @ inertia @ down
        rigid[joint.parent] += down.T @ rigid[joint.child] @ down
    return found


def _leaves_first(joints: Mapping[str, FrameJoint], root: str) -> Iterable[tuple[str, FrameJoint]]:
    below: dict[str, list[tuple[str, FrameJoint]]] = {}
    for name, joint in joints.items():
        below.setdefault(joint.parent, []).append((name, joint))
    order, waiting = list[tuple[str, FrameJoint]](), [root]
    while waiting:
        inner = below.get(waiting.pop(), [])
        order += inner
        waiting += [joint.child for _, joint in inner]
    return reversed(order)


def _spatial_inertia(link: ElementTree.Element) -> Array:
    """The inertia (6, 6) of a link about the origin of its frame: turns first."""
    inertial = link.find("inertial")
    place, rotation = (np.zeros(3), np.eye(3)) if inertial is None else pose_of(inertial)
    mass, lever = mass_of(link), skew(place)
    moments = rotation @ inertia_tensor(link) @ rotation.T + mass * lever @ lever.T
    return np.block([[moments, mass * lever], [mass * lever.T, mass * np.eye(3)]])


def _motion_transform(place: Array, rotation: Array) -> Array:
    """The (6, 6) that takes motions in a parent's frame to its child's."""
    return np.block([[rotation.T, np.zeros((3, 3))], [-rotation.T @ skew(place), rotation.T]])
