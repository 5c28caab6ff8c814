"""Displacing contacts by probing: lift them, move them through the air, put them down again (Sec. 4.1.2)."""

from __future__ import annotations

import math

import numpy as np

from graspdsl.arrays import Array
from graspdsl.basis.algebra import damped_pseudo_inverse, in_rows
from graspdsl.worlds.bullet.engine import CONTROL_RATE
from graspdsl.worlds.bullet.world import BulletWorld
from graspdsl.worlds.protocol import Command, Observation

LIFT = 0.010  # m off the surface
AIR_SPEED = 0.05  # m/s
TOUCH_SPEED = 0.02  # m/s
LONGEST_APPROACH = 0.04  # m
SETTLE_TICKS = 5
DAMPING = 0.02


class ProbingWorld(BulletWorld):
    """The bullet world in which a displacement of the contacts, x, is one probe of many ticks.

    Joint displacements, q, are carried out as in the bullet world, for the guarded close before the first probe.
    """

    def step(self, command: Command) -> Observation:
        """One probe for x (k, 3) [m], one tick for q."""
        if command.space != "x":
            return super().step(command)
        self._stopped[:] = False
        before = self._tips.read()
        self._carry(-LIFT * before.normals)
        self._carry(command.displacement)
        for _ in range(round(LONGEST_APPROACH / TOUCH_SPEED * CONTROL_RATE)):
            touching = self._tips.read().touching
            if touching.all():
                break
            self._nudge(np.where(touching[:, None], 0.0, before.normals * (TOUCH_SPEED / CONTROL_RATE)))
        for _ in range(SETTLE_TICKS):
            self._advance(np.zeros(len(self.info.joints)))
        return self._observe()

    def _carry(self, offsets: Array) -> None:
        """Move the fingertips by offsets (k, 3) [m], straight and together."""
        start, _ = self._centres()
        farthest = float(np.linalg.norm(offsets, axis=1).max())
        ticks = max(1, math.ceil(farthest / AIR_SPEED * CONTROL_RATE))
        for tick in range(1, ticks + 1):
            centres, jacobian = self._centres()
            self._servo(start + offsets * (tick / ticks) - centres, jacobian)

    def _nudge(self, offsets: Array) -> None:
        """Displace the fingertips by small offsets (k, 3) [m] in one tick."""
        _, jacobian = self._centres()
        self._servo(offsets, jacobian)

    def _servo(self, error: Array, jacobian: Array) -> None:
        weights = np.array(self.settings.robot.weights)
        inverse = damped_pseudo_inverse(DAMPING, in_rows(jacobian * weights))
        self._advance(weights * (inverse @ error.ravel()))

    def _centres(self) -> tuple[Array, Array]:
        """Centres (k, 3) [m] of the fingertips and their Jacobians (k, 3, n)."""
        joints = self.hand.all_joints()
        frames = self.hand.tip_frames()
        tips = self.hand.tips
        centres = [origin + rotation @ tip.centre for tip, (origin, rotation) in zip(tips, frames, strict=True)]
        return np.array(centres), np.array([self.hand.jacobians(tip, tip.centre, joints)[0] for tip in tips])
