"""How a robot's joints move its fingertips, how wide they open and what they press with, from its description alone."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import combinations
from xml.etree import ElementTree

import numpy as np

from graspdsl.arrays import Array
from graspdsl.basis.algebra import cross
from graspdsl.basis.rotations import exponential
from graspdsl.hands.descriptions import Robot, coupling_of, joint_limits
from graspdsl.hands.fingertips import CapsuleTip, EllipsoidTip, FingertipShape
from graspdsl.models.joint_kinds import FIXED, ROTATING
from graspdsl.models.urdf_elements import axis_of, pose_of

POSTURES, FINE = 9, 40  # from open to closed
ARM_POSTURES = 16  # over the ranges of the joints of an arm


@dataclass(frozen=True, slots=True)
class Press:
    """The force [N] that a fingertip presses with along its closing motion, and the joint that has no more to give:
    its effort [N·m or N] and the lever [m] of the force about it, or the share (1) of it along a slide."""

    force: float
    joint: str
    effort: float
    lever: float
    turns: bool

    @property
    def strength(self) -> str:
        """What the joint has, in words."""
        return f"{self.effort:g} N·m at a lever of {1000 * self.lever:.3g} mm" if self.turns else f"{self.effort:g} N"


@dataclass(frozen=True, slots=True)
class _Mover:
    """A joint on the way to a fingertip: its pose in the frame before it, its unit axis there; its row among all that
    move, None for a fixed one; ``carries``: whether it is one of the mount."""

    name: str
    place: Array
    rotation: Array
    axis: Array
    turns: bool
    row: int | None
    carries: bool


@dataclass(frozen=True, slots=True)
class LinkMotion:
    """A link where some joints put it: origin (..., 3) [m] and rotation (..., 3, 3) in the frame of the
    robot's root. ``axes``: the joints before it, each with its place and its axis (..., 3) there."""

    origin: Array
    rotation: Array
    axes: tuple[tuple[_Mover, Array, Array], ...]
    coupling: Array

    def point(self, place: Array) -> Array:
        """A point (..., 3) [m] that is fixed in the link at a place (3,)."""
        return np.asarray(self.origin + self.rotation @ place)

    def columns(self, place: Array) -> tuple[Array, Array]:
        """Linear and angular Jacobians (..., 3, m) of such a point by all m joints that move, coupled ones too."""
        point = self.point(place)
        linear = np.zeros((*point.shape, len(self.coupling)))
        angular = np.zeros_like(linear)
        for mover, at, axis in self.axes:
            linear[..., mover.row] = cross(axis, point - at) if mover.turns else axis
            angular[..., mover.row] = axis if mover.turns else 0.0
        return linear, angular

    def jacobians(self, place: Array) -> tuple[Array, Array]:
        """Linear and angular Jacobians (..., 3, n) of such a point."""
        linear, angular = self.columns(place)
        return linear @ self.coupling, angular @ self.coupling


class FingertipMotion:
    """The Jacobians of a robot's fingertips, by all joints that move, coupled ones too, and by those it drives."""

    def __init__(self, robot: Robot) -> None:
        self._robot = robot
        elements = [joint for model in robot.models for joint in ElementTree.fromstring(model).iter("joint")]
        moving = [joint for joint in elements if joint.get("type") != FIXED]
        self._rows = {joint.get("name", ""): row for row, joint in enumerate(moving)}
        self._turns = [joint.get("type") in ROTATING for joint in moving]
        limits = [joint.find("limit") for joint in moving]
        self._efforts = np.array([0.0 if limit is None else float(limit.get("effort", "0")) for limit in limits])
        ends = [
            [0.0] if limit is None else [float(limit.get(end, "0")) for end in ("lower", "upper")] for limit in limits
        ]
        self._travels = [max(map(abs, places)) for places in ends]
        self._coupling = coupling_of(robot, list(self._rows))
        self._chains = [list(self._chain(contact.link, elements)) for contact in robot.hand.contacts.values()]
        self._face = list(self._chain(robot.mount.face, elements))

    def _chain(self, link: str, elements: list[ElementTree.Element]) -> Iterator[_Mover]:
        """The joints from the robot's root to a link."""
        before = {_end(joint, "child"): joint for joint in elements}
        path, carries = list[tuple[ElementTree.Element, bool]](), False
        while link in before or link == self._robot.hand.root:
            joint = before.get(link)
            path += [] if joint is None else [(joint, carries)]
            carries = carries or joint is None
            link = self._robot.mount.face if joint is None else _end(joint, "parent")
        for joint, carries in reversed(path):
            axis, name = axis_of(joint), joint.get("name", "")
            turns = joint.get("type") in ROTATING
            yield _Mover(name, *pose_of(joint), axis / np.linalg.norm(axis), turns, self._rows.get(name), carries)

    def _link(self, chain: Sequence[_Mover], places: Array) -> tuple[LinkMotion, tuple[Array, Array]]:
        """The link at the end of a chain, all joints that move being at places (..., m), and the frame of the hand's
        root, both in that of the robot's."""
        origin: Array = np.zeros(3)
        frame: Array = np.eye(3)
        root, axes = (origin, frame), list[tuple[_Mover, Array, Array]]()
        for mover in chain:
            origin, frame = origin + frame @ mover.place, frame @ mover.rotation
            if mover.row is not None:
                axis, place = frame @ mover.axis, places[..., mover.row, None]
                axes.append((mover, origin, axis))
                if mover.turns:
                    frame = frame @ exponential(place * mover.axis)
                else:
                    origin = origin + place * axis
            if mover.carries:
                root = origin, frame
        return LinkMotion(origin, frame, tuple(axes), self._coupling), root

    def links(self, joints: Array) -> list[LinkMotion]:
        """The fingertips' links at joints (..., n), in the frame of the robot's root."""
        return [self._link(chain, joints @ self._coupling.T)[0] for chain in self._chains]

    def face(self, joints: Array) -> LinkMotion:
        """The mounting face at joints (..., n), in the frame of the robot's root."""
        link, batch = self._link(self._face, joints @ self._coupling.T)[0], joints.shape[:-1]
        # Slides alone turn nothing, and what turns about the face does not move it.
        origin, rotation = np.broadcast_to(link.origin, (*batch, 3)), np.broadcast_to(link.rotation, (*batch, 3, 3))
        return LinkMotion(origin, rotation, link.axes, link.coupling)

    def _moved(self, joints: Array) -> tuple[Array, Array, Array]:
        """The fingertips' centres (..., k, 3) [m] at joints (..., n), in the frame of the hand's root, and their linear
        and angular Jacobians (..., k, 3, m) by all m joints that move, in that of the robot's."""
        places = joints @ self._coupling.T
        centres = np.zeros((*joints.shape[:-1], len(self._chains), 3))
        linear = np.zeros((*centres.shape, places.shape[-1]))
        angular = np.zeros_like(linear)
        for tip, (contact, chain) in enumerate(zip(self._robot.hand.contacts.values(), self._chains, strict=True)):
            link, (start, turned) = self._link(chain, places)
            centre = np.array(contact.shape.centre)
            centres[..., tip, :] = ((link.point(centre) - start)[..., None, :] @ turned)[..., 0, :]
            linear[..., tip, :, :], angular[..., tip, :, :] = link.columns(centre)
        return centres, linear, angular

    def centres(self, joints: Array) -> Array:
        """The fingertips' centres (..., k, 3) [m] in the frame of the hand's root, at joints (..., n)."""
        return self._moved(joints)[0]

    def jacobians(self, joints: Array) -> tuple[Array, Array]:
        """Linear and angular Jacobians (..., k, 3, n) of the fingertips' centres, at joints (..., n)."""
        _, linear, angular = self._moved(joints)
        return linear @ self._coupling, angular @ self._coupling

    def reach(self) -> float:
        """The largest distance [m] of a fingertip's surface ahead of the palm's, as the fingers open and close."""
        return float((self._path[..., 2] + self.radii).max()) - self._robot.hand.palm_surface

    def breadth(self) -> float:
        """The largest distance [m] of a fingertip's surface aside from the middle of the palm, as the fingers close."""
        return float((np.linalg.norm(self._path[..., :2], axis=-1) + self.radii).max())

    def span(self) -> float:
        """A distance [m] from the hand's root beyond which no fingertip gets, whatever its joints: that of all links on
        end, slides at their farther limits."""
        spans = []
        for contact, chain in zip(self._robot.hand.contacts.values(), self._chains, strict=True):
            own = [mover for mover in chain if not mover.carries]
            slid = sum(self._travels[mover.row] for mover in own if mover.row is not None and not mover.turns)
            links = sum(float(np.linalg.norm(mover.place)) for mover in own)
            spans.append(slid + links + float(np.linalg.norm(contact.shape.centre)) + _farthest(contact.shape))
        return max(spans)

    def openings(self) -> Array:
        """How wide every two fingertips are apart as the fingers open and close, and how far ahead of the palm.

        (m, 2) [m]: the gap between their surfaces, and the least distance of their centres from the palm's surface.
        """
        one, other = np.array(list(combinations(range(len(self.radii)), 2)), dtype=int).reshape(-1, 2).T
        apart = np.linalg.norm(self._path[:, one] - self._path[:, other], axis=-1)
        gaps = apart - self.radii[one] - self.radii[other]
        ahead = np.minimum(self._path[:, one, 2], self._path[:, other, 2]) - self._robot.hand.palm_surface
        return np.stack([gaps, ahead], axis=-1).reshape(-1, 2)

    @cached_property
    def _path(self) -> Array:
        """The fingertips' centres (FINE, k, 3) [m] as the fingers close."""
        return self.centres(self.closing(FINE))

    @cached_property
    def radii(self) -> Array:
        """How far the surface of each fingertip is from its centre [m], at the least."""
        shapes = [contact.shape for contact in self._robot.hand.contacts.values()]
        return np.array([min(shape.semi_axes) if isinstance(shape, EllipsoidTip) else shape.radius for shape in shapes])

    def closing(self, count: int) -> Array:
        """Joints (count, n) on the way from the open to the closed posture, the mount's at zero."""
        opened, closed = self._posture("open"), self._posture("closed")
        return np.asarray(opened + np.linspace(0.0, 1.0, count)[:, None] * (closed - opened))

    def _posture(self, name: str) -> Array:
        places = self._robot.hand.postures.get(name, {})
        return np.array([places.get(joint, 0.0) for joint in self._robot.joints])

    def strongest(self) -> tuple[Press | None, ...]:
        """The strongest press of each fingertip anywhere on its way from the open to the closed posture.

        A force f along the unit direction d in which its finger closes asks each joint for the effort f d·∂x/∂q_j:
        the first that has no more ends it. None for a finger that does not close, or whose joints have no efforts.
        """
        motion, names = self._posture("closed") - self._posture("open"), list(self._robot.joints)
        _, linear, _ = self._moved(self.closing(POSTURES))
        return tuple(
            self._press(linear[:, tip], self._coupling @ np.where(np.isin(names, contact.finger), motion, 0.0))
            for tip, contact in enumerate(self._robot.hand.contacts.values())
        )

    def _press(self, columns: Array, motion: Array) -> Press | None:
        """The strongest press of a fingertip with these columns (p, 3, m), along what a motion (m,) does to it."""
        along = columns @ motion
        lengths = np.linalg.norm(along, axis=-1, keepdims=True)
        levers = np.abs(along[:, None, :] @ columns)[:, 0] / np.where(lengths > 0.0, lengths, 1.0)
        able = (levers > 0.0) & (self._efforts > 0.0)
        forces = np.where(able, self._efforts, np.inf) / np.where(able, levers, 1.0)
        most = np.where(able.any(axis=-1), forces.min(axis=-1), -np.inf)
        at = int(np.argmax(most))
        if not able[at].any():
            return None
        weakest = int(np.argmin(forces[at]))
        effort, lever = float(self._efforts[weakest]), float(levers[at, weakest])
        return Press(float(most[at]), list(self._rows)[weakest], effort, lever, bool(self._turns[weakest]))

    def largest_singular_value(self, turning: bool, enough: float) -> float:
        """That of the Jacobian of all fingertips together, linear or of their turning, in scaled joint coordinates.

        The greatest over postures from open to closed and, for an arm, over places spread over the ranges of its
        joints; or of the first places of an arm at which it is greater than ``enough``.
        """
        robot, largest = self._robot, 0.0
        weights, mount = np.array(robot.weights), np.isin(list(robot.joints), list(robot.mount.joints))
        arms = np.zeros((1, len(weights)))
        if robot.mount.base:
            lower, upper = (np.array(limits) for limits in joint_limits(robot))
            shares = np.random.default_rng(0).uniform(size=(ARM_POSTURES, len(weights)))
            arms = np.vstack([arms, lower + shares * (upper - lower)])
        for arm in arms:
            jacobian = self.jacobians(np.where(mount, arm, self.closing(POSTURES)))[turning] * weights
            stacked = jacobian.reshape(POSTURES, -1, len(weights))
            largest = max(largest, float(np.linalg.norm(stacked, 2, axis=(-2, -1)).max()))
            if largest > enough:
                break
        return largest


def _farthest(shape: FingertipShape) -> float:
    """How far a fingertip reaches from its centre [m], at the most."""
    match shape:
        case EllipsoidTip():
            return max(shape.semi_axes)
        case CapsuleTip():
            return shape.radius + shape.length / 2
    return shape.radius


def _end(joint: ElementTree.Element, tag: str) -> str:
    end = joint.find(tag)
    return "" if end is None else end.get("link", "")
