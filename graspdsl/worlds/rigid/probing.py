"""Displacing contacts by probing: lift them, move them through the air, put them down again (Sec. 4.1.2)."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from graspdsl.arrays import Array
from graspdsl.basis.algebra import damped_pseudo_inverse, in_rows
from graspdsl.hands.descriptions import Robot
from graspdsl.worlds.rigid.engine import CONTROL_RATE, Stages
from graspdsl.worlds.rigid.feeling import felt
from graspdsl.worlds.touch.fingertips import Fingertips

LIFT = 0.010  # m off the surface
AIR_SPEED = 0.05  # m/s
TOUCH_SPEED = 0.02  # m/s
LONGEST_APPROACH = 0.04  # m
SETTLE_TICKS = 5
DAMPING = 0.02


class Probe:
    """The fingertips of a hand, which ``advance`` moves: one tick, its joints displaced by (1, n) [m or rad]."""

    def __init__(self, robot: Robot, alone: Stages, tips: Fingertips, advance: Callable[[Array], None]) -> None:
        """alone: the one stage that the hand is on."""
        self._robot, self._alone, self._tips, self._advance = robot, alone, tips, advance

    def displace(self, displacement: Array) -> None:
        """Displace the contacts by (k, 3) [m]: lifted, through the air, and down until all touch."""
        normals = felt(self._alone, self._alone.tip_frames(), [self._tips]).normals[0]
        self._carry(-LIFT * normals)
        self._carry(displacement)
        for _ in range(round(LONGEST_APPROACH / TOUCH_SPEED * CONTROL_RATE)):
            touching = felt(self._alone, self._alone.tip_frames(), [self._tips]).touching[0]
            if touching.all():
                break
            self._nudge(np.where(touching[:, None], 0.0, normals * (TOUCH_SPEED / CONTROL_RATE)))
        for _ in range(SETTLE_TICKS):
            self._advance(np.zeros((1, len(self._robot.joints))))

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
        self._advance((weights * (inverse @ error.ravel()))[None])

    def _centres(self) -> tuple[Array, Array]:
        """Centres (k, 3) [m] of the fingertips and their Jacobians (k, 3, n)."""
        frames, places = self._alone.tip_frames(), self._tips.centres[None]
        centres = frames.origins + np.matvec(frames.rotations, places)
        return centres[0], self._alone.tip_jacobians(frames, places)[0, 0]
