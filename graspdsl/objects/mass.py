"""The mass of solids of even density: volume, centre of mass, inertia."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from graspdsl.arrays import Array

DIAGONAL = 1e-9  # the share of products of inertia in the moments that is rounding


@dataclass(frozen=True, eq=False, slots=True)
class Solid:
    """Integrals over a volume V [m³]: its centre c (3,) [m] and ∫ (r − c)(r − c)ᵀ dV (3, 3) [m⁵]."""

    volume: float
    centre: Array
    moments: Array

    def inertia(self, mass: float) -> Array:
        """The inertia (3, 3) [kg m²] about the centre for a mass [kg] of even density."""
        tensor: Array = mass / self.volume * (np.trace(self.moments) * np.eye(3) - self.moments)
        return tensor

    def principal(self, mass: float) -> tuple[Array, Array]:
        """The principal moments of inertia (3,) [kg m²] and their axes, the columns of a rotation (3, 3).

        Where the axes of the frame are principal ones, they are kept.
        """
        inertia = self.inertia(mass)
        if np.abs(inertia - np.diag(np.diag(inertia))).max() < DIAGONAL * np.trace(inertia):
            return np.diag(inertia), np.eye(3)
        values, axes = np.linalg.eigh(inertia)
        return values, axes if np.linalg.det(axes) > 0.0 else -axes

    def placed(self, rotation: Array, position: Array) -> Solid:
        """The solid turned by a rotation (3, 3) about the origin, then moved by a position (3,) [m]."""
        return Solid(self.volume, rotation @ self.centre + position, rotation @ self.moments @ rotation.T)


def joined(solids: Iterable[Solid]) -> Solid:
    """Solids that do not overlap as one (the parallel-axis theorem)."""
    each = list(solids)
    volume = sum(solid.volume for solid in each)
    centre = sum((solid.volume * solid.centre for solid in each), np.zeros(3)) / volume
    moments = np.zeros((3, 3))
    for solid in each:
        away = solid.centre - centre
        moments += solid.moments + solid.volume * np.outer(away, away)
    return Solid(volume, centre, moments)
