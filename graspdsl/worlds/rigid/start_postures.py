"""Where the joints stand when a trial begins: found from geometry alone, before there is a world to simulate."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from graspdsl.arrays import Array
from graspdsl.diagnostics import listed
from graspdsl.hands.arm_reach import ArmReach
from graspdsl.hands.descriptions import joint_units
from graspdsl.hands.fingertip_motion import FingertipMotion
from graspdsl.worlds.kind import WorldSettings
from graspdsl.worlds.protocol import InfeasibleStartError, Start, UnreachableStartError
from graspdsl.worlds.rigid.engine import Engine, EnginePose
from graspdsl.worlds.start_pose import root_pose

CLEARANCE = 0.004  # m that a start keeps between the hand and everything else
PRESHAPE = 0.012  # m between a tip and the object when a trial begins
CLOSING_STEPS = {"rad": 0.02, "m": 0.01}
SEEN_AHEAD = 0.1  # m within which distances are asked for
ROUNDING = 1e-4  # m by which the engine's distances may be wrong


class StartPostures:
    """A robot beside an object at rest, in an engine's world of their own that is only asked for distances.

    It serves any number of starts: an answer does not depend on those before it. To be closed.
    """

    def __init__(self, engine: Engine[Any], settings: WorldSettings, resting: EnginePose | None) -> None:
        self._robot = settings.robot
        self._reach = ArmReach(self._robot) if self._robot.mount.base else None
        self._steps = np.array([CLOSING_STEPS[unit] for unit in joint_units(self._robot).values()])
        origin = Start(np.zeros(3), np.eye(3), {})
        self._stage = engine.stage(settings, *root_pose(self._robot, origin))
        if resting is not None:
            self._stage.scene.place(resting)
        self._hand = self._stage.hand
        corners = self._stage.scene.object_corners()
        self._low, self._high = corners.min(axis=0), corners.max(axis=0)
        # What stands still stands where it stands: an arm's base on the table.
        self._moved = self._hand.links_beyond(list(self._robot.joints)) if self._reach else None
        self._span = FingertipMotion(self._robot).span() + ROUNDING

    def close(self) -> None:
        """Give the engine's world back."""
        self._stage.close()

    def find(self, start: Start) -> Array:
        """The joints (n,) [m or rad] at a start, each finger closed until its tip is about to touch the object.

        Raises InfeasibleStartError when the arm cannot reach it, or a finger has no free place, or meets the object
        with another link, or not at all.
        """
        robot = self._robot
        if self._distance_from(start.position) > self._span:
            raise InfeasibleStartError("the object is farther away than the fingers are long")
        known = {**robot.hand.postures["open"], **start.posture}
        opened = np.array([known.get(name, 0.0) for name in robot.joints])
        if self._reach is None:
            self._hand.move_root(*root_pose(robot, start))
            return self._standing_free([self._preshape(opened)])
        arm = self._reach.postures(start.position, start.rotation)
        if not len(arm):
            raise UnreachableStartError("the arm cannot reach the start pose")
        fingers = len(arm[0])
        # How the fingers close does not depend on how the arm holds the hand.
        closed = self._preshape(np.concatenate([arm[0], opened[fingers:]]))[fingers:]
        return self._standing_free([np.concatenate([posture, closed]) for posture in arm])

    def _standing_free(self, postures: Sequence[Array]) -> Array:
        """The first of some postures that keeps clear of the table and the object."""
        for posture in postures:
            self._hand.place(posture)
            if self._stage.clearance(self._moved, CLEARANCE) >= CLEARANCE:
                return posture
        raise InfeasibleStartError("the robot would stand in the table or the object")

    def _preshape(self, posture: Array) -> Array:
        """A posture (n,) with each finger closed until its tip is about to touch the object; fingers that the same
        joints close, as one motor does those of a gripper, until the first of their tips is."""
        robot = self._robot
        names = list(robot.joints)
        closed = np.array([robot.hand.postures["closed"].get(name, 0.0) for name in names])
        closing: dict[tuple[str, ...], list[tuple[str, int]]] = {}
        for (name, contact), tip in zip(robot.hand.contacts.items(), self._hand.tip_links, strict=True):
            closing.setdefault(contact.finger, []).append((name, tip))
        for joints, ends in closing.items():
            contacts, tips = zip(*ends, strict=True)
            motion = np.where(np.isin(names, joints), closed - posture, 0.0)
            posture = self._close_finger(posture, motion, joints, tips, listed(contacts))
        return posture

    def _close_finger(
        self, posture: Array, motion: Array, joints: tuple[str, ...], tips: tuple[int, ...], name: str
    ) -> Array:
        """Close one finger in small steps until its tip touches the object; the posture shortly before that.

        Steps within which nothing can come near, however the finger moves, are not looked at.
        """
        if not motion.any():
            raise InfeasibleStartError(f"{name} starts closed")
        links = self._hand.links_beyond(joints)
        step = 1.0 / float((np.abs(motion) / self._steps).max())
        shares = np.arange(0.0, 1.0, step)
        self._hand.place(posture)
        travel = step * self._speed(motion, links)  # m a step, at most
        ready: Array | None = None
        met, number = False, 0
        while number < len(shares):
            self._hand.place(posture + shares[number] * motion)
            distance = min(self._stage.distance(tip, SEEN_AHEAD) for tip in tips)
            free = max(0, math.floor((min(distance, SEEN_AHEAD) - PRESHAPE - ROUNDING) / travel))  # steps
            others = self._stage.clearance(links - {*tips}, CLEARANCE + ROUNDING + free * travel)
            if ready is not None and distance <= 0.0:
                return ready
            met = met or min(distance, others) < CLEARANCE
            if others < CLEARANCE:
                ready = None
            elif distance >= PRESHAPE or (ready is None and distance >= CLEARANCE):
                if others < math.inf:
                    free = min(free, max(0, math.floor((others - CLEARANCE - ROUNDING) / travel)))
                number = min(number + free, len(shares) - 1)
                ready = posture + shares[number] * motion
            number += 1
        how = "meets the object or the table with another link" if met else "closes without meeting the object"
        raise InfeasibleStartError(f"{name} {how}")

    def _speed(self, motion: Array, links: set[int]) -> float:
        """How fast [m] any point of some links can move when the joints move by (n,), wherever the joints are.

        A point is no farther from the axis of a joint than along the chain of links to it.
        """
        hand = self._hand
        moves = dict(zip(hand.movable, np.abs(hand.coupling @ motion).tolist(), strict=True))
        origins, order = hand.link_origins(), sorted(links)
        fastest = 0.0
        for link, chain in zip(order, hand.link_sizes(order), strict=True):
            speed, at = 0.0, link
            while at in links:
                moved, parent = moves.get(at, 0.0), hand.parents[at]
                speed += moved if hand.slides[at] else moved * chain
                chain += float(np.linalg.norm(origins[at] - origins[parent])) + (moved if hand.slides[at] else 0.0)
                at = parent
            fastest = max(fastest, speed)
        return fastest

    def _distance_from(self, point: Array) -> float:
        """A distance [m] that the object is away from a point (3,) at the least: that of the box it is in."""
        return float(np.linalg.norm(point - np.clip(point, self._low, self._high)))
