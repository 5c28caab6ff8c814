"""Rotations by roll, pitch and yaw, as files of robots have them."""

from __future__ import annotations

import math

import numpy as np

from graspdsl.arrays import Array


def roll_pitch_yaw(rotation: Array) -> tuple[float, float, float]:
    """The angles [rad] about x, then y, then z of fixed axes, as a URDF has them, that make a rotation (3, 3).

    At a pitch of ±π/2 only the sum or the difference of roll and yaw is told by the rotation: any of them is returned.
    """
    pitch = math.atan2(-rotation[2, 0], math.hypot(rotation[0, 0], rotation[1, 0]))
    yaw = math.atan2(rotation[1, 0], rotation[0, 0])
    # The roll of what remains without the yaw is right however badly the yaw is told.
    _, y, z = math.cos(yaw) * rotation[1] - math.sin(yaw) * rotation[0]
    return math.atan2(-z, y), pitch, yaw


def turned_by_angles(rpy: tuple[float, float, float]) -> Array:
    """The rotation (3, 3) about x, then y, then z of fixed axes, Rz(yaw) Ry(pitch) Rx(roll), as a URDF has it."""
    (sr, sp, sy), (cr, cp, cy) = ([trigonometric(angle) for angle in rpy] for trigonometric in (math.sin, math.cos))
    return np.array(
        [
            [cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr],
            [sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr],
            [-sp, cp * sr, cp * cr],
        ]
    )
