"""The sphere."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from graspdsl.arrays import Array
from graspdsl.objects.surfaces.mesh import unit_sphere
from graspdsl.objects.surfaces.surface import Surface
from graspdsl.objects.surfaces.vectors import directions, lengths

UP = np.array([0.0, 0.0, 1.0])


@dataclass(frozen=True)
class Sphere(Surface):
    """|x| = diameter / 2, the diameter in m. ``level`` is the signed distance; the centre goes to the top."""

    diameter: float

    def __post_init__(self) -> None:
        if not self.diameter > 0.0:
            raise ValueError(f"the diameter of a sphere must be positive, not {self.diameter}")

    @property
    def extent(self) -> tuple[float, float, float]:
        """Full size along x, y, z [m]."""
        return (self.diameter,) * 3

    def level(self, points: Array) -> Array:
        """|x| − diameter / 2 [m], (...)."""
        return lengths(points) - self.diameter / 2

    def normals(self, points: Array) -> Array:
        """x / |x|, (..., 3)."""
        return directions(points, otherwise=UP)

    def nearest(self, points: Array) -> Array:
        """The nearest point (..., 3) [m], in closed form."""
        return self.diameter / 2 * self.normals(points)

    def sample(self, count: int, random: np.random.Generator) -> Array:
        """Directions of normally distributed vectors, (count, 3) [m]."""
        return self.nearest(random.normal(size=(count, 3)))

    def rings(self, count: int) -> Array:
        """Circles of latitude (count + 1, 2 count, 3) [m]."""
        return self.diameter / 2 * unit_sphere(count)
