"""An observation in general position: what holds of its numbers holds of almost all."""

from __future__ import annotations

import numpy as np

from graspdsl.hands.descriptions import Robot
from graspdsl.worlds.protocol import Observation


def in_general_position(robot: Robot, seed: int = 0) -> Observation:
    """Contacts that all touch, everything about them at random; the object is held."""
    random = np.random.default_rng(seed)
    count, joints = len(robot.contacts), len(robot.joints)
    normals = random.normal(size=(count, 3))
    return Observation(
        time=0.0,
        points=random.normal(scale=0.05, size=(count, 3)),
        normals=normals / np.linalg.norm(normals, axis=-1, keepdims=True),
        forces=random.normal(size=(count, 3)),
        touching=np.ones(count, dtype=bool),
        joints=random.normal(size=joints),
        jacobian=random.normal(scale=0.1, size=(count, 3, joints)),
        angular_jacobian=random.normal(size=(count, 3, joints)),
        orientations=random.normal(size=(count, 3)),
        centre_of_mass=random.normal(scale=0.05, size=3),
        weight=np.array([0.0, 0.0, -1.0]),
    )
