"""Table and object inside Bullet, and the engine's truth about what touches the object."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from graspdsl.arrays import Array
from graspdsl.objects.shapes import Body
from graspdsl.worlds.bullet.hand import BulletHand
from graspdsl.worlds.bullet.solids import put_body, speck
from graspdsl.worlds.camera import box_corners
from graspdsl.worlds.kind import Anchor
from graspdsl.worlds.protocol import TABLE_SIZE

OUT_OF_THE_WAY = 1.0  # m
WOOD = (0.76, 0.62, 0.46, 1.0)
UP = np.array([0.0, 0.0, 1.0])

Pose = tuple[tuple[float, ...], tuple[float, ...]]  # centre of mass [m], quaternion (x, y, z, w)


class Scene:
    """A table whose top is z = 0 and one object that stands on it at the origin.

    For a held object the table is lowered out of the way; ``attach`` fixes the object to the hand. What is not ``seen``
    has no looks.
    """

    def __init__(
        self, engine: Any, client: int, body: Body, table_friction: float, anchor: Anchor, *, seen: bool = False
    ) -> None:
        self._engine, self._client = engine, client
        self.table = self._put_table(-OUT_OF_THE_WAY if anchor is Anchor.HAND else 0.0, seen)
        self.mass = body.mass
        self._rolls = body.shape.rolls
        self._body = put_body(engine, client, body, fixed=anchor is Anchor.WORLD, seen=seen)
        self.object = self._body.index
        self._body.move(engine, client, np.array([0.0, 0.0, body.shape.extent[2] / 2]))
        # The engine multiplies the coefficients of two bodies: the object's is one, the others say theirs.
        engine.changeDynamics(self.table, -1, lateralFriction=table_friction, physicsClientId=client)
        engine.changeDynamics(self.object, -1, lateralFriction=1.0, physicsClientId=client)
        self.mark_rest()

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

    def _put_table(self, top: float, seen: bool) -> int:
        engine, client, half = self._engine, self._client, [size / 2 for size in TABLE_SIZE]
        collision = engine.createCollisionShape(engine.GEOM_BOX, halfExtents=half, physicsClientId=client)
        wood = {"halfExtents": half, "rgbaColor": WOOD, "physicsClientId": client}
        visual = engine.createVisualShape(engine.GEOM_BOX, **wood) if seen else speck(engine, client)
        place = [0.0, 0.0, top - half[2]]
        index: int = engine.createMultiBody(0.0, collision, visual, place, physicsClientId=client)
        return index

    def place(self, pose: Pose) -> None:
        """Put the object into a pose, at rest."""
        self._engine.resetBasePositionAndOrientation(self.object, *pose, self._client)
        self._engine.resetBaseVelocity(self.object, [0, 0, 0], [0, 0, 0], self._client)

    def put(self, centre: Array, rotation: Array) -> None:
        """Put the object into a pose as ``object_pose`` tells it."""
        self._body.place(self._engine, self._client, centre, rotation)

    def mark_rest(self) -> None:
        """Take the object's present pose as the one it is compared with."""
        self._rest_up = self.object_pose()[1].T @ UP

    def object_pose(self) -> tuple[Array, Array]:
        """The object's centre of mass (3,) [m] and the rotation (3, 3) of its body frame."""
        return self._body.pose(self._engine, self._client)

    def object_corners(self) -> Array:
        """The corners (8, 3) [m] of a box along the axes of the world that the object is in."""
        low, high = self._engine.getAABB(self.object, physicsClientId=self._client)
        return box_corners(np.array(low), np.array(high))

    def lean(self) -> float:
        """The angle [rad] by which what was up in the object at rest is off the vertical; a ball may roll."""
        if self._rolls:
            return 0.0
        up = self.object_pose()[1] @ self._rest_up
        return math.atan2(float(np.hypot(up[0], up[1])), float(up[2]))

    def distance_from(self, point: Array) -> float:
        """A distance [m] that the object is away from a point (3,) at the least: that of the box it is in."""
        low, high = self._engine.getAABB(self.object, physicsClientId=self._client)
        return float(np.linalg.norm(point - np.clip(point, low, high)))

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

    def distance_to_object(self, hand: int, link: int, within: float) -> float:
        """The distance [m] between a link of the hand and the object; infinite above ``within``."""
        return min((pair[8] for pair in self.closest(hand, link, within)), default=math.inf)

    def closest(self, hand: int, link: int, within: float) -> list[tuple[Any, ...]]:
        """The engine's pairs of near points of a link of the hand and of the object, at most ``within`` [m] apart."""
        pairs = self._engine.getClosestPoints(hand, self.object, within, linkIndexA=link, physicsClientId=self._client)
        return list(pairs)

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
