"""Squeezing: normal forces that balance each other, raised through the transpose of the fingers' Jacobian."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.optimize import nnls

from graspdsl.arrays import Array
from graspdsl.basis.algebra import cross
from graspdsl.hands.descriptions import Robot
from graspdsl.worlds.protocol import Observation

ADMITTANCE = 1e-4  # m/N a tick; times a soft tip's 1500 N/m the loop gain is 0.15
EVENNESS = 1e-3


def balanced_forces(points: Array, normals: Array) -> Array:
    """The normal forces (k,) of mean 1 that leave the least net wrench, moments over the contacts' own size.

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
    return np.asarray(forces * count / forces.sum())


class Squeeze:
    """Force control of a grasp's squeeze alone: one number s [N], the mean normal force, forces s·f̂ in balance f̂.

    A tick displaces the finger joints by Δq = g W² Jᵀ Σ f̂ᵢ nᵢ (s − f̂·f / f̂·f̂): the transpose of the fingers' own
    Jacobian, W their weights, g the admittance. What f̂ does not span, where the object is between the fingers, is left
    to the stiff joints, so that fingers of unequal strength do not push the object away.
    """

    def __init__(self, robot: Robot, contacts: Sequence[int], observation: Observation) -> None:
        self._contacts = list(contacts)
        self._balance = balanced_forces(observation.points[self._contacts], observation.normals[self._contacts])
        names = list(robot.joints)
        fingers = [robot.hand.contacts[robot.contacts[contact]].finger for contact in self._contacts]
        self._weights = np.array([[robot.joints[j].weight if j in own else 0.0 for j in names] for own in fingers])

    def force(self, observation: Observation) -> float:
        """The present squeeze [N]: the part of the normal forces along the balance."""
        chosen = self._contacts
        normal = np.einsum("ki,ki->k", observation.forces[chosen], observation.normals[chosen])
        return float(self._balance @ normal / (self._balance @ self._balance))

    def displacement(self, observation: Observation, wanted: float) -> Array:
        """The displacement (n,) of the joints [rad] in a tick towards the wanted squeeze [N]."""
        chosen = self._contacts
        closing = np.einsum("ki,kin->kn", observation.normals[chosen], observation.jacobian[chosen])
        error = wanted - self.force(observation)
        step: Array = ADMITTANCE * error * (self._balance @ (self._weights**2 * closing))
        return step
