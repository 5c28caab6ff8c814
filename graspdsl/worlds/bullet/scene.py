"""Table and object inside Bullet, and the engine's truth about what touches the object."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from graspdsl.arrays import Array
from graspdsl.basis.algebra import cross
from graspdsl.objects.shapes import Body
from graspdsl.worlds.bullet.hand import BulletHand
from graspdsl.worlds.bullet.solids import put_body, speck
from graspdsl.worlds.camera import box_corners
from graspdsl.worlds.kind import Anchor
from graspdsl.worlds.protocol import PARTIES, TABLE_SIZE
from graspdsl.worlds.rigid.engine import OUT_OF_THE_WAY, ROLLING_RESISTANCE, EnginePose, stands_free, stands_still


class Touch(NamedTuple):
    """A contact of the object with a link of another ``body``, at a ``place`` (3,) [m] of the object.

    ``sign``: 1 where the engine tells what acts on the object, -1 where it tells what acts on the other.
    """

    body: int
    link: int
    place: tuple[float, ...]
    sign: float
    contact: tuple[Any, ...]


def forces_of(touches: Sequence[Touch]) -> Array:
    """The forces (c, 3) [N] of contacts on the object, along their normals and by friction."""
    rows = np.array([(*c[7], *c[11], *c[13], c[9], c[10], c[12], sign) for *_, sign, c in touches]).reshape(-1, 13)
    directions = rows[:, :9].reshape(-1, 3, 3)
    return np.asarray(rows[:, 12:] * np.einsum("cs,csi->ci", rows[:, 9:12], directions))


class Scene:
    """A table whose top is z = 0 and one object that stands on it at the origin.

    For an object that is held or afloat the table is lowered out of the way; ``attach`` fixes the object to the hand,
    ``stand_on`` lets another hand hold it.
    """

    def __init__(self, engine: Any, client: int, body: Body, table_friction: float, anchor: Anchor) -> None:
        self._engine, self._client = engine, client
        self.table = self._put_table(0.0 if stands_free(anchor) else -OUT_OF_THE_WAY)
        self.mass = body.mass
        self._body = put_body(engine, client, body, fixed=stands_still(anchor))
        self.object = self._body.index
        self._body.move(engine, client, np.array([0.0, 0.0, body.shape.extent[2] / 2]))
        # The engine multiplies the coefficients of two bodies: the object's is one, the others say theirs.
        engine.changeDynamics(self.table, -1, lateralFriction=table_friction, physicsClientId=client)
        engine.changeDynamics(self.object, -1, lateralFriction=1.0, physicsClientId=client)
        if body.shape.lies_round:
            engine.changeDynamics(self.table, -1, rollingFriction=ROLLING_RESISTANCE, physicsClientId=client)
        self.forget()

    def attach(self, hand: BulletHand) -> None:
        """Fix the object to the hand's palm where it is."""
        engine, client = self._engine, self._client
        palm = hand.link_index[hand.robot.hand.palm]
        state = engine.getLinkState(hand.body, palm, physicsClientId=client)
        back_position, back_rotation = engine.invertTransform(state[0], state[1])
        position, quaternion = engine.getBasePositionAndOrientation(self.object, client)
        local = engine.multiplyTransforms(back_position, back_rotation, position, quaternion)
        engine.createConstraint(
            hand.body,
            palm,
            self.object,
            -1,
            engine.JOINT_FIXED,
            [0, 0, 0],
            local[0],
            [0, 0, 0],
            local[1],
            physicsClientId=client,
        )

    def stand_on(self, hand: BulletHand) -> None:
        """Let the links of a mount that no joint moves hold the object, and press on nothing."""
        for link in hand.still_links():
            self._engine.setCollisionFilterPair(hand.body, self.object, link, -1, 0, self._client)

    def _put_table(self, top: float) -> int:
        engine, client, half = self._engine, self._client, [size / 2 for size in TABLE_SIZE]
        collision = engine.createCollisionShape(engine.GEOM_BOX, halfExtents=half, physicsClientId=client)
        place = [0.0, 0.0, top - half[2]]
        index: int = engine.createMultiBody(0.0, collision, speck(engine, client), place, physicsClientId=client)
        return index

    def place(self, pose: EnginePose) -> None:
        """Put the object into a pose, at rest."""
        self._engine.resetBasePositionAndOrientation(self.object, *pose, self._client)
        self._engine.resetBaseVelocity(self.object, [0, 0, 0], [0, 0, 0], self._client)

    def pose(self) -> EnginePose:
        """Where the object is, as the engine has it."""
        position, quaternion = self._engine.getBasePositionAndOrientation(self.object, self._client)
        return position, quaternion

    def velocity(self) -> tuple[Array, Array]:
        """The object's velocities (3,) [m/s] and (3,) [rad/s]."""
        moving, turning = self._engine.getBaseVelocity(self.object, self._client)
        return np.array(moving), np.array(turning)

    def move(self, velocity: Array, rate: Array) -> None:
        """Give the object velocities (3,) [m/s] and (3,) [rad/s]."""
        self._engine.resetBaseVelocity(self.object, velocity.tolist(), rate.tolist(), self._client)

    def object_pose(self) -> tuple[Array, Array]:
        """The object's centre of mass (3,) [m] and the rotation (3, 3) of its body frame."""
        return self._body.pose(self._engine, self._client)

    def object_corners(self) -> Array:
        """The corners (8, 3) [m] of a box along the axes of the world that the object is in."""
        low, high = self._engine.getAABB(self.object, physicsClientId=self._client)
        return box_corners(np.array(low), np.array(high))

    def clearance(self, hand: int, links: set[int] | None, within: float) -> float:
        """The least distance [m] between these links of the hand (None: all) and the table or the object.

        Distances above ``within`` count as infinite.
        """
        parts: list[dict[str, int]] = [{}] if links is None else [{"linkIndexA": link} for link in links]
        near = [
            self._engine.getClosestPoints(hand, other, within, physicsClientId=self._client, **part)
            for other in (self.table, self.object)
            for part in parts
        ]
        return min((point[8] for points in near for point in points), default=math.inf)

    def closest(self, hand: int, link: int, within: float) -> list[tuple[Any, ...]]:
        """The engine's pairs of near points of a link of the hand and of the object, at most ``within`` [m] apart."""
        pairs = self._engine.getClosestPoints(hand, self.object, within, linkIndexA=link, physicsClientId=self._client)
        return list(pairs)

    def touches(self) -> list[Touch]:
        """The engine's contacts of the object in its last step."""
        found = []
        # Asked for one body alone, the engine turns normals so that they are on that, but leaves friction as it is.
        for contact in self._engine.getContactPoints(physicsClientId=self._client):
            if contact[1] == self.object:
                found.append(Touch(contact[2], contact[4], contact[5], 1.0, contact))
            elif contact[2] == self.object:
                found.append(Touch(contact[1], contact[3], contact[6], -1.0, contact))
        return found

    def forget(self) -> None:
        """Forget what has acted on the object."""
        self._acted: list[list[Touch]] = []
        self._moved: list[tuple[tuple[float, ...], tuple[float, ...]]] = []

    def note(self) -> None:
        """Note what acts on the object in the step of physics that was just taken."""
        position, _ = self._engine.getBasePositionAndOrientation(self.object, self._client)
        velocity, _ = self._engine.getBaseVelocity(self.object, self._client)
        self._moved.append((position, velocity))
        self._acted.append(self.touches())

    def loads(self, hand: BulletHand, gravity: float, time_step: float) -> Array:
        """What PARTIES put on the object (4, 6): force [N], then moment [N·m] about its centre of mass.

        Means over the steps that were noted: over these they add up to the change of the object's momentum, but for the
        engine's own damping, which at a velocity v takes 0.04 (1 + |v|) of it a second. One step alone would not do:
        the engine's contacts may press by turns, each every other step.
        """
        tips = {tip.link for tip in hand.tips}
        loads = np.zeros((len(PARTIES), 6))
        loads[PARTIES.index("gravity"), 2] = -self.mass * gravity
        touches = [touch for found in self._acted for touch in found]
        if not touches:
            return loads
        positions, velocities = np.array(self._moved).swapaxes(0, 1)
        # The engine tells contacts where they were as the step [s] began.
        centres = np.repeat(positions - time_step * velocities, [len(found) for found in self._acted], axis=0)
        forces = forces_of(touches)
        levers = np.array([touch.place for touch in touches]) - centres
        parties = [2 if touch.body == self.table else 0 if touch.link in tips else 1 for touch in touches]
        np.add.at(loads, parties, np.hstack([forces, cross(levers, forces)]) / len(self._acted))
        return loads

    def other_links(self, hand: BulletHand) -> tuple[str, ...]:
        """Names of the hand's links other than fingertips that press on the object."""
        tips = {tip.link for tip in hand.tips}
        pressing = self.pressing(hand, self.object)
        return tuple(sorted({hand.link_names[c[3]] for c in pressing if c[3] not in tips}))

    def table_links(self, hand: BulletHand) -> tuple[str, ...]:
        """Names of the robot's links that press on the table; its base stands still and is none of them."""
        pressing = self.pressing(hand, self.table)
        return tuple(sorted({hand.link_names[c[3]] for c in pressing if c[3] >= 0}))

    def pressing(self, hand: BulletHand, other: int, link: int | None = None) -> list[tuple[Any, ...]]:
        """The engine's contacts of the hand, or of one link of it, with another body that carry a force."""
        of_link = {} if link is None else {"linkIndexA": link}
        contacts = self._engine.getContactPoints(hand.body, other, physicsClientId=self._client, **of_link)
        return [contact for contact in contacts if contact[9] > 0.0]
