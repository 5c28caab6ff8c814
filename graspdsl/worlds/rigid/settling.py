"""How an object stands on the table before a hand comes near: its resting pose, if it has one."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from graspdsl.objects.shapes import Body
from graspdsl.objects.standing import STANDING
from graspdsl.worlds.protocol import UnstableObjectError
from graspdsl.worlds.rigid.engine import Engine, EnginePose, Stage
from graspdsl.worlds.rigid.lean import Standing

SETTLING_TIME = 4.0  # s, at most
RESTING_TIME = 0.1  # s
RESTING_SPEED = 1e-3  # m/s
RESTING_RATE = 1e-2  # rad/s
# What balances on a tip falls when it is nudged: in this time a pendulum of 30 cm grows its angle a thousandfold.
NUDGE = 0.02  # rad/s
NUDGED_TIME = 1.2  # s


def resting_pose(engine: Engine[Any], body: Body, table_friction: float, gravity: float) -> EnginePose:
    """The pose that an object comes to rest in, put down on a table about the origin and let go.

    A cylinder, a box or a ball rests as it is put down. Raises UnstableObjectError for what does not stay near the pose
    it was put down in. It is found in a world of its own, so that a trial does not depend on those before it.
    """
    stage: Stage = engine.table(body, table_friction, gravity)
    try:
        trial = _Settling(stage, engine.time_step, Standing.of(stage.scene.object_pose()[1], body.shape))
        if not body.shape.rests:
            trial.settle()
        return stage.scene.pose()
    finally:
        stage.close()


@dataclass(frozen=True, slots=True)
class _Settling:
    stage: Stage
    time_step: float
    begun: Standing

    def settle(self) -> None:
        """Wait for the object to be at rest, and see whether it stays there when it is nudged."""
        still = 0.0
        for _ in range(round(SETTLING_TIME / self.time_step)):
            self.stage.step()
            still = still + self.time_step if self._is_at_rest() else 0.0
            if still >= RESTING_TIME:
                break
        self._must_stand()
        if still < RESTING_TIME:
            raise UnstableObjectError(f"the object does not come to rest on the table within {SETTLING_TIME:g} s")
        pose = self.stage.scene.pose()
        self.stage.scene.move(np.zeros(3), np.array([NUDGE, NUDGE, 0.0]))
        for _ in range(round(NUDGED_TIME / self.time_step)):
            self.stage.step()
        if self._lean() > STANDING:
            for _ in range(round(SETTLING_TIME / self.time_step)):
                self.stage.step()
            self._must_stand()
        self.stage.scene.place(pose)

    def _lean(self) -> float:
        """In degrees."""
        return math.degrees(self.begun.lean(self.stage.scene.object_pose()[1]))

    def _is_at_rest(self) -> bool:
        moving, turning = self.stage.scene.velocity()
        return bool(np.linalg.norm(moving) < RESTING_SPEED and np.linalg.norm(turning) < RESTING_RATE)

    def _must_stand(self) -> None:
        fallen = self._lean()
        if fallen > STANDING:
            raise UnstableObjectError(f"the object does not stand: put on the table, it fell over by {fallen:.0f}°")
