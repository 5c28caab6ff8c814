"""Forward kinematics of a hand from its model, without any engine: where fingertips are, and how wide a hand opens."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache
from xml.etree import ElementTree

import numpy as np

from graspdsl.arrays import Array
from graspdsl.basis.rotations import exponential
from graspdsl.hands.articulated_inertia import axis_of, pose_of
from graspdsl.hands.descriptions import Robot
from graspdsl.hands.fingertips import EllipsoidTip

POSTURES = 40  # between open and closed


def fingertips_at(robot: Robot, joints: Mapping[str, float]) -> Array:
    """The centres (k, 3) [m] of a hand's fingertips in the frame of its root, its joints [rad or m] as named.

    Joints that are not named are at zero, but for those that follow others.
    """
    chains = _chains(robot.models[-1])
    followers = robot.hand.couplings.items()
    places = {name: coupling.ratio * joints.get(coupling.follows, 0.0) for name, coupling in followers}
    centres = []
    for contact in robot.hand.contacts.values():
        point = np.array(contact.shape.centre)
        for joint in reversed(chains[contact.link]):
            name, kind = joint.get("name", ""), joint.get("type")
            moved = places.get(name, joints.get(name, 0.0))
            if kind in ("revolute", "continuous"):
                point = exponential(moved * axis_of(joint)) @ point
            elif kind == "prismatic":
                point = point + moved * axis_of(joint)
            position, rotation = pose_of(joint)
            point = rotation @ point + position
        centres.append(point)
    return np.array(centres)


def reach_of(robot: Robot) -> float:
    """The largest distance [m] of a fingertip's surface from the root of its hand, as the fingers open and close."""
    return max(
        float(np.linalg.norm(centre)) + radius
        for centres in _closing(robot)
        for centre, radius in zip(centres, _radii(robot), strict=True)
    )


def openings_of(robot: Robot) -> Array:
    """How wide a hand opens, and how far ahead of its palm, (m, 2) [m], as its fingers open and close.

    The gap between the surfaces of two fingertips, and the least distance of their centres from the palm's surface; of
    every two fingertips.
    """
    radii, surface = _radii(robot), robot.hand.palm_surface
    return np.array(
        [
            (
                float(np.linalg.norm(centres[a] - centres[b])) - radii[a] - radii[b],
                float(min(centres[a, 2], centres[b, 2])) - surface,
            )
            for centres in _closing(robot)
            for a in range(len(centres))
            for b in range(a)
        ]
    ).reshape(-1, 2)


def _closing(robot: Robot) -> list[Array]:
    """The fingertips' centres (k, 3) in postures from open to closed."""
    hand = robot.hand
    opened = {name: hand.postures["open"].get(name, 0.0) for name in hand.joints}
    closed = {name: hand.postures["closed"].get(name, 0.0) for name in hand.joints}
    shares = np.linspace(0.0, 1.0, POSTURES)
    return [
        fingertips_at(robot, {name: opened[name] + share * (closed[name] - opened[name]) for name in opened})
        for share in shares
    ]


def _radii(robot: Robot) -> list[float]:
    """How far the surface of each fingertip is from its centre [m], at the least."""
    shapes = [contact.shape for contact in robot.hand.contacts.values()]
    return [min(shape.semi_axes) if isinstance(shape, EllipsoidTip) else shape.radius for shape in shapes]


@cache
def _chains(model: str) -> Mapping[str, tuple[ElementTree.Element, ...]]:
    """The joints from the root to every link of a model, the first one first."""
    joints = {}
    for joint in ElementTree.fromstring(model).findall("joint"):
        ends = [joint.find("parent"), joint.find("child")]
        parent, child = ("" if end is None else end.get("link", "") for end in ends)
        joints[child] = (parent, joint)

    def to(link: str) -> tuple[ElementTree.Element, ...]:
        if link not in joints:
            return ()
        parent, joint = joints[link]
        return (*to(parent), joint)

    return {link: to(link) for link in joints}
