"""Displacing contacts by probing: lift them, move them through the air, put them down again (Sec. 4.1.2)."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from graspdsl.arrays import Array
from graspdsl.basis.algebra import damped_pseudo_inverse, in_rows
from graspdsl.hands.descriptions import Robot
from graspdsl.worlds.rigid.engine import CONTROL_RATE, StagedHand
from graspdsl.worlds.touch.fingertips import Fingertips

LIFT = 0.010  # m off the surface
AIR_SPEED = 0.05  # m/s
TOUCH_SPEED = 0.02  # m/s
LONGEST_APPROACH = 0.04  # m
SETTLE_TICKS = 5
DAMPING = 0.02


class Probe:
    """The fingertips of a hand, which ``advance`` moves: one tick, its joints displaced by (n,) [m or rad]."""

    def __init__(self, hand: StagedHand, tips: Fingertips, advance: Callable[[Array], None]) -> None:
        self._hand, self._tips, self._advance = hand, tips, advance

    def displace(self, displacement: Array) -> None:
        """Displace the contacts by (k, 3) [m]: lifted, through the air, and down until all touch."""
        before = self._tips.read()
        self._carry(-LIFT * before.normals)
        self._carry(displacement)
        for _ in range(round(LONGEST_APPROACH / TOUCH_SPEED * CONTROL_RATE)):
            touching = self._tips.read().touching
            if touching.all():
                break
            self._nudge(np.where(touching[:, None], 0.0, before.normals * (TOUCH_SPEED / CONTROL_RATE)))
        for _ in range(SETTLE_TICKS):
            self._advance(np.zeros(len(self._robot.joints)))

    @property
    def _robot(self) -> Robot:
        return self._hand.robot

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
        weights = np.array(self._robot.weights)
        inverse = damped_pseudo_inverse(DAMPING, in_rows(jacobian * weights))
        self._advance(weights * (inverse @ error.ravel()))

    def _centres(self) -> tuple[Array, Array]:
        """Centres (k, 3) [m] of the fingertips and their Jacobians (k, 3, n)."""
        tips, frames = self._hand.tips, self._hand.tip_frames()
        centres = [origin + rotation @ tip.centre for tip, (origin, rotation) in zip(tips, frames, strict=True)]
        return np.array(centres), self._hand.tip_jacobians([tip.centre for tip in tips])[0]
