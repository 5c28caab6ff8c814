"""Where the joints stand when a trial begins: found from geometry alone, before there is a world to simulate."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from graspdsl.arrays import Array
from graspdsl.hands.descriptions import Robot, joint_limits
from graspdsl.hands.fingertip_motion import FingertipMotion
from graspdsl.objects.shapes import Body
from graspdsl.worlds.bullet.engine import pybullet, silenced
from graspdsl.worlds.bullet.hand import BulletHand, Tip
from graspdsl.worlds.bullet.reach import ArmReach
from graspdsl.worlds.bullet.scene import Pose, Scene
from graspdsl.worlds.camera import box_corners
from graspdsl.worlds.kind import Anchor
from graspdsl.worlds.protocol import InfeasibleStartError, Start
from graspdsl.worlds.start_pose import root_pose

CLEARANCE = 0.004  # m that a start keeps between the hand and everything else
PRESHAPE = 0.012  # m between a tip and the object when a trial begins
CLOSING_STEP = 0.02  # rad
SEEN_AHEAD = 0.1  # m within which distances are asked for
ROUNDING = 1e-4  # m by which the engine's distances may be wrong


class StartPostures:
    """A robot beside an object at rest, in an engine's world of their own that is only asked for distances.

    It serves any number of starts: an answer does not depend on those before it. To be closed.
    """

    def __init__(self, robot: Robot, body: Body, anchor: Anchor, resting: Pose | None) -> None:
        self._robot, self._engine = robot, pybullet()
        self._lower, self._upper = (np.array(limits) for limits in joint_limits(robot))
        with silenced():
            self._client: int = self._engine.connect(self._engine.DIRECT)
        self._scene = Scene(self._engine, self._client, body, 0.0, anchor)
        if resting is not None:
            self._scene.place(resting)
        origin = Start(np.zeros(3), np.eye(3), {})
        self._hand = BulletHand(self._engine, self._client, robot, *root_pose(robot, origin), 0.0)
        self._span = FingertipMotion(robot).span() + ROUNDING

    def close(self) -> None:
        """Give the engine's world back."""
        self._engine.disconnect(self._client)

    def find(self, start: Start) -> Array:
        """The joints (n,) [m or rad] at a start, each finger closed until its tip is about to touch the object.

        Raises InfeasibleStartError when the arm cannot reach it, or a finger has no free place, or meets the object
        with another link, or not at all.
        """
        robot = self._robot
        if self._scene.distance_from(start.position) > self._span:
            raise InfeasibleStartError("the object is farther away than the fingers are long")
        known = {**robot.hand.postures["open"], **start.posture}
        opened = np.array([known.get(name, 0.0) for name in robot.joints])
        if robot.mount.base is None:
            self._hand.move_root(*root_pose(robot, start))
            return self._standing_free([self._preshape(opened)])
        reaching = ArmReach(self._hand, start.position, start.rotation, self._lower, self._upper)
        first = reaching.any_posture(opened)
        # How the fingers close does not depend on how the arm holds the hand.
        return self._standing_free(reaching.postures(self._preshape(first)))

    def _standing_free(self, postures: Sequence[Array]) -> Array:
        """The first of some postures that keeps clear of the table and the object."""
        for posture in postures:
            self._hand.place(posture)
            if self._scene.clearance(self._hand.body, None, CLEARANCE) >= CLEARANCE:
                return posture
        raise InfeasibleStartError("the robot would stand in the table or the object")

    def _preshape(self, posture: Array) -> Array:
        """A posture (n,) with each finger closed until its tip is about to touch the object."""
        robot = self._robot
        names = list(robot.joints)
        closed = np.array([robot.hand.postures["closed"].get(name, 0.0) for name in names])
        for (name, contact), tip in zip(robot.hand.contacts.items(), self._hand.tips, strict=True):
            mine = np.isin(names, contact.finger)
            posture = self._close_finger(posture, np.where(mine, closed - posture, 0.0), contact.finger, tip, name)
        return posture

    def _close_finger(self, posture: Array, motion: Array, joints: tuple[str, ...], tip: Tip, name: str) -> Array:
        """Close one finger in small steps until its tip touches the object; the posture shortly before that.

        Steps within which nothing can come near, however the finger moves, are not looked at.
        """
        if not motion.any():
            raise InfeasibleStartError(f"{name} starts closed")
        links = self._hand.links_beyond(joints)
        step = CLOSING_STEP / float(np.abs(motion).max())
        candidates = [posture + share * motion for share in np.arange(0.0, 1.0, step)]
        self._hand.place(posture)
        travel = step * self._speed(motion, links)  # m a step, at most
        ready: Array | None = None
        met, number = False, 0
        while number < len(candidates):
            self._hand.place(candidates[number])
            distance = self._scene.distance_to_object(self._hand.body, tip.link, SEEN_AHEAD)
            free = max(0, math.floor((min(distance, SEEN_AHEAD) - PRESHAPE - ROUNDING) / travel))  # steps
            others = self._scene.clearance(self._hand.body, links - {tip.link}, CLEARANCE + ROUNDING + free * travel)
            if ready is not None and distance <= 0.0:
                return ready
            met = met or min(distance, others) < CLEARANCE
            if others < CLEARANCE:
                ready = None
            elif distance >= PRESHAPE or (ready is None and distance >= CLEARANCE):
                if others < math.inf:
                    free = min(free, max(0, math.floor((others - CLEARANCE - ROUNDING) / travel)))
                number = min(number + free, len(candidates) - 1)
                ready = candidates[number]
            number += 1
        how = "meets the object or the table with another link" if met else "closes without meeting the object"
        raise InfeasibleStartError(f"{name} {how}")

    def _speed(self, motion: Array, links: set[int]) -> float:
        """How fast [m] any point of some links can move when the joints move by (n,), wherever the joints are.

        A point is no farther from the axis of a joint than along the chain of links to it.
        """
        hand, engine, client = self._hand, self._engine, self._client
        moves = dict(zip(hand.movable, np.abs(hand.coupling @ motion).tolist(), strict=True))
        every = list(range(len(hand.parents)))
        states = engine.getLinkStates(hand.body, every, computeForwardKinematics=True, physicsClientId=client)
        origins = [np.array(state[4]) for state in states]
        slides = [engine.getJointInfo(hand.body, link, client)[2] == engine.JOINT_PRISMATIC for link in every]
        fastest = 0.0
        for link in links:
            low, high = engine.getAABB(hand.body, link, client)
            away = np.linalg.norm(box_corners(np.array(low), np.array(high)) - origins[link], axis=1)
            chain, speed, at = float(away.max()), 0.0, link
            while at in links:
                moved, parent = moves.get(at, 0.0), hand.parents[at]
                speed += moved if slides[at] else moved * chain
                chain += float(np.linalg.norm(origins[at] - origins[parent])) + (moved if slides[at] else 0.0)
                at = parent
            fastest = max(fastest, speed)
        return fastest
