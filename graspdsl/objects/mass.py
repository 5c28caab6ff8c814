"""The mass of solids of even density: volume, centre of mass, inertia."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from graspdsl.arrays import Array
from graspdsl.objects.surfaces.profile import Profile

DIAGONAL = 1e-9  # the share of products of inertia in the moments that is rounding
OUTLINE = 400  # lines for a half turn of an arc: the volume of a ball so drawn is off by 2e-5


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

    @property
    def radius_of_gyration(self) -> float:
        """√(tr I / 3m) [m]: that about an axis, √(I/m), in the mean square over all axes through the centre.

        A body that turns about it with ω has on average the energy that it has when it moves with this radius times ω.
        """
        return float(np.sqrt(2.0 * np.trace(self.moments) / (3.0 * self.volume)))

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


def symmetric(volume: float, size: tuple[float, float, float], share: float) -> Solid:
    """A volume about the origin with ∫ x² dV = share · V · size²."""
    return Solid(volume, np.zeros(3), share * volume * np.diag(np.square(size)))


def dirichlet(exponent: float, *powers: int) -> float:
    """∫ Π x_i^(α_i − 1) dx over Σ x_i^p ≤ 1, x_i ≥ 0: Π Γ(α_i/p) / (p^m Γ(1 + Σ α_i/p)), Dirichlet's integral."""
    product = math.prod(math.gamma(power / exponent) / exponent for power in powers)
    return product / math.gamma(1.0 + sum(powers) / exponent)


def stacked_solid(profile: Profile, width: float = 1.0, exponent: float = 2.0) -> Solid:
    """Sections |x/ρ|^n + |y/(wρ)|^n ≤ 1 over the outline ρ(z): Gauss's rule, exact for each straight piece."""
    outline = profile.outline(OUTLINE)
    nodes, weights = np.polynomial.legendre.leggauss(3)
    low, high = outline[:-1, None], outline[1:, None]
    points = (low + high) / 2 + (high - low) / 2 * nodes[None, :, None]
    rho, z, heights = points[..., 0], points[..., 1], (high - low)[..., 1] / 2 * weights
    area = 4.0 * width * dirichlet(exponent, 1, 1) * rho**2 * heights
    spread = 4.0 * dirichlet(exponent, 3, 1) * rho**4 * heights
    volume = float(area.sum())
    middle = float((area * z).sum()) / volume
    moments = np.diag([width * spread.sum(), width**3 * spread.sum(), (area * (z - middle) ** 2).sum()])
    return Solid(volume, np.array([0.0, 0.0, middle]), moments)
