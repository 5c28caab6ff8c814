"""Squeezing: normal forces that balance each other, raised by moving the fingertips along their normals."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.optimize import nnls

from graspdsl.arrays import Array
from graspdsl.basis.algebra import cross, damped_pseudo_inverse
from graspdsl.hands.descriptions import Robot
from graspdsl.worlds.protocol import Observation

ADMITTANCE = 5e-5  # m/N a tick; times the 3700 N/m of a tip under 15 N the loop gain is 0.19
EVENNESS = 1e-3
DAMPING = 1e-2


def balanced_forces(points: Array, normals: Array) -> Array:
    """The normal forces (k,), the largest 1, that leave the least net wrench, moments over the contacts' own size.

    points, normals: (k, 3). Non-negative least squares, with so little weight on even forces that these only decide
    between balances that are as good.
    """
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
        step: Array = self._weights * (damped_pseudo_inverse(DAMPING, jacobian) @ closing.ravel())
        return step
