"""Carrying an object about: the palm follows a path by Cartesian servo while the fingers hold their squeeze."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from graspdsl.arrays import Array
from graspdsl.basis.algebra import damped_pseudo_inverse
from graspdsl.basis.rotations import exponential, logarithm
from graspdsl.hands.descriptions import Robot
from graspdsl.quality.squeeze import Squeeze
from graspdsl.worlds.protocol import Command, Observation, PalmWorld

FEEDBACK = 0.2  # of the palm's error, a tick
DAMPING = 1e-3


class Carrier:
    """A hand that holds on with some of its contacts and keeps the orientation of its palm.

    The mount's joints move the palm along the path, through the damped pseudo-inverse of its Jacobian; where the palm
    goes to squeeze is added to the path. The world keeps joints within their limits.
    """

    def __init__(self, world: PalmWorld, robot: Robot, contacts: Sequence[int]) -> None:
        self._world, self._mount_joints = world, len(robot.mount.joints)
        self.observation: Observation = world.step(Command("q", np.zeros(len(world.info.joints))))
        self._squeeze = Squeeze(robot, contacts, self.observation)
        palm = world.palm()
        self._start, self._rotation = palm.position, palm.rotation
        self._offset = np.zeros(3)

    @property
    def squeeze(self) -> float:
        """The present squeeze [N], as the hand senses it."""
        return self._squeeze.force(self.observation)

    def tick(self, offset: Array, squeeze: float) -> None:
        """One tick in which the palm goes to an offset (3,) [m] from where it took hold; squeeze [N].

        The step of the path is fed forward and what is left of the last one fed back.
        """
        palm = self._world.palm()
        behind = self._start + self._offset - palm.position
        turned = logarithm(self._rotation @ palm.rotation.T)
        motion = np.concatenate([offset - self._offset + FEEDBACK * behind, FEEDBACK * turned])
        mount = palm.jacobian[:, : self._mount_joints]
        step = self._squeeze.displacement(self.observation, squeeze)
        given_way = palm.jacobian @ step
        step[: self._mount_joints] += damped_pseudo_inverse(DAMPING, mount) @ motion
        self._offset = offset
        self._start = self._start + given_way[:3]
        self._rotation = exponential(given_way[3:]) @ self._rotation
        self.observation = self._world.step(Command("q", step))
