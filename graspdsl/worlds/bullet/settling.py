"""How an object stands on the table before a hand comes near: its resting pose, if it has one."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np

from graspdsl.objects.shapes import Body
from graspdsl.objects.standing import STANDING
from graspdsl.worlds.bullet.engine import TIME_STEP, pybullet, silenced
from graspdsl.worlds.bullet.scene import Pose, Scene
from graspdsl.worlds.kind import Anchor
from graspdsl.worlds.protocol import UnstableObjectError

SETTLING_TIME = 4.0  # s, at most
RESTING_TIME = 0.1  # s
RESTING_SPEED = 1e-3  # m/s
RESTING_RATE = 1e-2  # rad/s
# What balances on a tip falls when it is nudged: in this time a pendulum of 30 cm grows its angle a thousandfold.
NUDGE = 0.02  # rad/s
NUDGED_TIME = 1.2  # s


@cache
def resting_pose(body: Body, table_friction: float, gravity: float) -> Pose:
    """The pose that an object comes to rest in, put down on a table about the origin and let go.

    A cylinder, a box or a ball rests as it is put down. Raises UnstableObjectError for what does not stay near the pose
    it was put down in. It is found in a world of its own, so that a trial does not depend on those before it.
    """
    engine = pybullet()
    with silenced():
        client = engine.connect(engine.DIRECT)
    try:
        engine.setTimeStep(TIME_STEP, client)
        engine.setGravity(0, 0, -gravity, client)
        trial = _Settling(engine, client, Scene(engine, client, body, table_friction, Anchor.NONE))
        if not body.shape.rests:
            trial.settle()
        return trial.pose
    finally:
        engine.disconnect(client)


@dataclass(frozen=True, slots=True)
class _Settling:
    engine: Any
    client: int
    scene: Scene

    @property
    def pose(self) -> Pose:
        position, quaternion = self.engine.getBasePositionAndOrientation(self.scene.object, self.client)
        return position, quaternion

    def settle(self) -> None:
        """Wait for the object to be at rest, and see whether it stays there when it is nudged."""
        still = 0.0
        for _ in range(round(SETTLING_TIME / TIME_STEP)):
            self._simulate()
            still = still + TIME_STEP if self._is_at_rest() else 0.0
            if still >= RESTING_TIME:
                break
        self._must_stand()
        if still < RESTING_TIME:
            raise UnstableObjectError(f"the object does not come to rest on the table within {SETTLING_TIME:g} s")
        pose = self.pose
        self.engine.resetBaseVelocity(self.scene.object, [0, 0, 0], [NUDGE, NUDGE, 0], self.client)
        for _ in range(round(NUDGED_TIME / TIME_STEP)):
            self._simulate()
        if math.degrees(self.scene.lean()) > STANDING:
            for _ in range(round(SETTLING_TIME / TIME_STEP)):
                self._simulate()
            self._must_stand()
        self.scene.place(pose)

    def _simulate(self) -> None:
        self.engine.stepSimulation(self.client)

    def _is_at_rest(self) -> bool:
        moving, turning = self.engine.getBaseVelocity(self.scene.object, self.client)
        return bool(np.linalg.norm(moving) < RESTING_SPEED and np.linalg.norm(turning) < RESTING_RATE)

    def _must_stand(self) -> None:
        fallen = math.degrees(self.scene.lean())
        if fallen > STANDING:
            raise UnstableObjectError(f"the object does not stand: put on the table, it fell over by {fallen:.0f}°")
