"""The sphere."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from pydantic import Field

from graspdsl.arrays import Array, Flags
from graspdsl.objects.facets import Hull, round_hull
from graspdsl.objects.mass import Solid, symmetric
from graspdsl.objects.shape import DescribedShape, Extent, Size
from graspdsl.objects.surfaces.mesh import unit_sphere
from graspdsl.objects.surfaces.surface import Surface
from graspdsl.objects.surfaces.vectors import directions, lengths

UP = np.array([0.0, 0.0, 1.0])


class Sphere(DescribedShape):
    """A ball."""

    name: ClassVar = "sphere"
    about: ClassVar = "a ball"
    rests: ClassVar = True
    rolls: ClassVar = True

    diameter: Size = Field(description="diameter (m), 0.005 to 2", examples=[0.10])

    @property
    def extent(self) -> Extent:
        """Full size along x, y, z [m]."""
        return (self.diameter,) * 3

    @property
    def primitive(self) -> tuple[str, tuple[float, ...]]:
        """A sphere of a radius."""
        return "sphere", (self.diameter / 2,)

    @property
    def solid(self) -> Solid:
        """V = π d³ / 6, ∫ x² dV = V d² / 20."""
        return symmetric(math.pi / 6 * self.diameter**3, self.extent, 1 / 20)

    def support(self, direction: Array) -> float:
        """|d| times the radius."""
        return self.diameter / 2 * float(np.linalg.norm(direction))

    def surface(self) -> SmoothSphere:
        """All of it."""
        return SmoothSphere(self.diameter)

    def hulls(self) -> tuple[Hull, ...]:
        """One, with a margin that rounds it."""
        return (round_hull(self.extent, 2.0),)

    def inside(self) -> Callable[[Array], Flags]:
        """Nearer to the centre than the radius."""
        return lambda points: np.array(np.linalg.norm(points, axis=-1) < self.diameter / 2)


@dataclass(frozen=True)
class SmoothSphere(Surface):
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
