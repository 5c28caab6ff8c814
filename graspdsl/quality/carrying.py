"""Carrying an object about: the palm follows a path by Cartesian servo while the fingers hold their squeeze.

To squeeze: normal forces that balance each other, raised by moving the fingertips along their normals.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from graspdsl.arrays import Array
from graspdsl.basis.algebra import cross, damped_pseudo_inverse
from graspdsl.basis.rotations import exponential, logarithm
from graspdsl.hands.descriptions import Robot
from graspdsl.worlds.protocol import Command, Observation, PalmWorld

FEEDBACK = 0.2  # of the palm's error, a tick
DAMPING = 1e-3
ADMITTANCE = 5e-5  # m/N a tick; times the 3700 N/m of a tip under 15 N the loop gain is 0.19
EVENNESS = 1e-3
SQUEEZE_DAMPING = 1e-2


def balanced_forces(points: Array, normals: Array) -> Array:
    """The normal forces (k,), the largest 1, that leave the least net wrench, moments over the contacts' own size.

    points, normals: (k, 3). Non-negative least squares, with so little weight on even forces that these only decide
    between balances that are as good.
    """
    from scipy.optimize import nnls

    count = len(points)
    levers = points - points.mean(axis=0)
    size = float(np.linalg.norm(levers, axis=1).max()) or 1.0
    wrenches = np.hstack([normals, cross(levers, normals) / size]).T
    total = 1e3 * np.ones((1, count))
    rows = np.vstack([wrenches, EVENNESS * np.eye(count), total])
    forces, _ = nnls(rows, np.concatenate([np.zeros(6), np.full(count, EVENNESS), total.sum(axis=1)]))
    return np.asarray(forces / forces.max())


class Squeeze:
    """Force control of a grasp's squeeze alone: one number s [N], the largest normal force, forces s·f̂ in balance f̂.

    A tick moves contact i by g f̂ᵢ nᵢ (s − f̂·f / f̂·f̂), g the admittance, and along nothing else: fingers that close on
    arcs of their own would shear the object until it slips, so the mount goes with them. What f̂ does not span, where
    the object is between the fingers, is left to the stiff joints: fingers of unequal strength do not push it away.
    """

    def __init__(self, robot: Robot, contacts: Sequence[int], observation: Observation) -> None:
        self._contacts = list(contacts)
        self._balance = balanced_forces(observation.points[self._contacts], observation.normals[self._contacts])
        idle = {
            joint
            for row, contact in enumerate(robot.contacts)
            if row not in self._contacts
            for joint in robot.hand.contacts[contact].finger
        }
        self._weights = np.array([0.0 if name in idle else joint.weight for name, joint in robot.joints.items()])

    def force(self, observation: Observation) -> float:
        """The present squeeze [N]: the part of the normal forces along the balance."""
        chosen = self._contacts
        normal = np.einsum("ki,ki->k", observation.forces[chosen], observation.normals[chosen])
        return float(self._balance @ normal / (self._balance @ self._balance))

    def displacement(self, observation: Observation, wanted: float) -> Array:
        """The displacement (n,) of the joints [m or rad] in a tick towards the wanted squeeze [N]."""
        chosen = self._contacts
        error = wanted - self.force(observation)
        closing = ADMITTANCE * error * self._balance[:, None] * observation.normals[chosen]
        jacobian = observation.jacobian[chosen].reshape(3 * len(chosen), -1) * self._weights
        step: Array = self._weights * (damped_pseudo_inverse(SQUEEZE_DAMPING, jacobian) @ closing.ravel())
        return step


class Carrier:
    """A hand that holds on with some of its contacts and keeps the orientation of its palm.

    The mount's joints move the palm along the path, through the damped pseudo-inverse of its Jacobian; where the palm
    goes to squeeze is added to the path. The world keeps joints within their limits.
    """

    def __init__(self, world: PalmWorld, robot: Robot, contacts: Sequence[int], observation: Observation) -> None:
        """observation: the present one; the latest is to be put in its place before each command."""
        self._world, self._mount_joints, self.observation = world, len(robot.mount.joints), observation
        self._squeeze = Squeeze(robot, contacts, observation)
        palm = world.palm()
        self._start, self._rotation = palm.position, palm.rotation
        self._offset = np.zeros(3)

    @property
    def squeeze(self) -> float:
        """The present squeeze [N], as the hand senses it."""
        return self._squeeze.force(self.observation)

    def command(self, offset: Array, squeeze: float) -> Command:
        """That of a tick in which the palm goes to an offset (3,) [m] from where it took hold; squeeze [N].

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
        return Command("q", step)
