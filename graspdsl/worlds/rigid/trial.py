"""A trial in a world of rigid bodies: a hand at its start before an object, and how it goes on, tick by tick."""

from __future__ import annotations

import numpy as np

from graspdsl.arrays import Array
from graspdsl.worlds.kind import Anchor, WorldSettings
from graspdsl.worlds.protocol import Names, WorldInfo
from graspdsl.worlds.rigid.engine import CONTROL_RATE, Stage
from graspdsl.worlds.rigid.lean import Standing
from graspdsl.worlds.touch.fingertip_sensor import Clock
from graspdsl.worlds.touch.fingertips import Fingertips

SETTLE_TICKS = 10
MOST_AHEAD = 0.05  # rad or m, of a target before its joint


class RigidTrial:
    """A scene that stands, with what a trial knows from one tick to the next: ``ticks`` so far, the motors' ``target``
    (n,) [m or rad], which joints the last step would have ``stopped`` (n,) at their limits, ``tips``, the tactile
    sensors, and how the object stood at first, ``standing``; ``ramp`` (s, 1): the share of a tick that is over after
    each of its steps. To be closed."""

    def __init__(
        self, stage: Stage, settings: WorldSettings, info: WorldInfo, posture: Array, steps: int, seed: int
    ) -> None:
        """Joints (n,) take up a posture, the hand settles, and its sensors are tared; a tick has so many steps."""
        self.stage, self._info = stage, info
        self.target, self.stopped = posture, np.zeros(len(posture), dtype=bool)
        stage.hand.place(posture)
        if settings.anchor is Anchor.HAND:
            stage.attach()
        self.ticks = 0
        self.ramp = (np.arange(1, steps + 1) / steps)[:, None]
        clock = Clock(CONTROL_RATE * steps, CONTROL_RATE)
        self.tips = Fingertips(stage.fingertips, settings.robot, settings.sensing, settings.gravity, clock, seed)
        for _ in range(SETTLE_TICKS):
            self._rest()
        self.tare()
        topples = settings.anchor is not Anchor.AFLOAT
        self.standing = Standing.of(stage.scene.object_pose()[1], settings.body.shape, topples)

    @property
    def stopped_joints(self) -> Names:
        """The names of the joints that the last step would have sent beyond their limits."""
        return tuple(name for name, stopped in zip(self._info.joints, self.stopped.tolist(), strict=True) if stopped)

    def tare(self) -> None:
        """Rest for the time that the sensors take to tare, and take what they read then as their zero."""
        for _ in range(round(self._info.tare_s * CONTROL_RATE)):
            self._rest()
            self.tips.note_rest()
        self.tips.tare()

    def _rest(self) -> None:
        """One tick in which nothing is driven elsewhere."""
        self.stage.simulate(np.broadcast_to(self.target, (len(self.ramp), len(self.target))), self.tips.advance)
