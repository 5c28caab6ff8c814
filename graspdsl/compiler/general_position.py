"""An observation in general position: what holds of its numbers holds of almost all."""

from __future__ import annotations

import math
from random import Random

import numpy as np

from graspdsl.arrays import Array
from graspdsl.hands.descriptions import Robot
from graspdsl.worlds.protocol import Observation


def in_general_position(robot: Robot, seed: int = 0) -> Observation:
    """Contacts that all touch, everything about them at random; the object is held."""
    random = Random(seed)  # not numpy's, which takes longer to import than to use

    def normal(*shape: int, scale: float = 1.0) -> Array:
        return np.array([random.gauss(0.0, scale) for _ in range(math.prod(shape))]).reshape(shape)

    count, joints = len(robot.contacts), len(robot.joints)
    normals = normal(count, 3)
    return Observation(
        time=0.0,
        points=normal(count, 3, scale=0.05),
        normals=normals / np.linalg.norm(normals, axis=-1, keepdims=True),
        forces=normal(count, 3),
        touching=np.ones(count, dtype=bool),
        joints=normal(joints),
        jacobian=normal(count, 3, joints, scale=0.1),
        angular_jacobian=normal(count, 3, joints),
        orientations=normal(count, 3),
        centre_of_mass=normal(3, scale=0.05),
        weight=np.array([0.0, 0.0, -1.0]),
    )
