"""The ellipsoid."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from pydantic import Field

from graspdsl.arrays import Array, namespace, repeated
from graspdsl.objects.facets import Hull, round_hull
from graspdsl.objects.mass import Solid, symmetric
from graspdsl.objects.shape import UPRIGHT, DescribedShape, Extent, Sizes
from graspdsl.objects.surfaces.mesh import unit_sphere
from graspdsl.objects.surfaces.sampling import accepted
from graspdsl.objects.surfaces.surface import Surface
from graspdsl.objects.surfaces.vectors import axis_of_least, directions, lengths

ENOUGH = 1.0 + 4 * float(np.finfo(np.float64).eps)
MOST_PASSES = 100
OFF_THE_PLANE = 1e-100


class Ellipsoid(DescribedShape):
    """An ellipsoid with axes along those of the world."""

    name: ClassVar = "ellipsoid"
    about: ClassVar = "an ellipsoid"
    upright: ClassVar = False

    size: Sizes = Field(description="full size along x, y and z (m), 0.005 to 2 each", examples=[[0.10, 0.12, 0.15]])

    @property
    def extent(self) -> Extent:
        """Full size along x, y, z [m]."""
        return self.size

    @property
    def axle(self) -> Extent | None:
        """The axis across two of equal size."""
        x, y, z = self.size
        pairs: tuple[tuple[Extent, bool], ...] = ((1.0, 0.0, 0.0), y == z), ((0.0, 1.0, 0.0), z == x), (UPRIGHT, x == y)
        across = [axis for axis, equal in pairs if equal]
        return across[0] if len(across) == 1 else None

    @property
    def solid(self) -> Solid:
        """V = π x y z / 6, ∫ x² dV = V x² / 20."""
        return symmetric(math.pi / 6 * math.prod(self.size), self.size, 1 / 20)

    def support(self, direction: Array) -> float:
        """√(Σ (d_i x_i / 2)²)."""
        return float(np.linalg.norm(direction * np.array(self.size) / 2))

    def surface(self) -> SmoothEllipsoid:
        """All of it."""
        x, y, z = self.size
        return SmoothEllipsoid((x / 2, y / 2, z / 2))

    def hulls(self) -> tuple[Hull, ...]:
        """One, with a margin that rounds it."""
        return (round_hull(self.size, 2.0),)


@dataclass(frozen=True)
class SmoothEllipsoid(Surface):
    """(x/a)² + (y/b)² + (z/c)² = 1 with semi axes (a, b, c) in m: half of the full size."""

    semi_axes: tuple[float, float, float]

    def __post_init__(self) -> None:
        if not min(self.semi_axes) > 0.0:
            raise ValueError(f"the semi axes of an ellipsoid must be positive, not {self.semi_axes}")

    @property
    def extent(self) -> tuple[float, float, float]:
        """Full size along x, y, z [m]."""
        a, b, c = self.semi_axes
        return (2 * a, 2 * b, 2 * c)

    def level(self, points: Array) -> Array:
        """(√((x/a)² + (y/b)² + (z/c)²) − 1) max(a, b, c) [m], (...)."""
        return (lengths(points / np.array(self.semi_axes)) - 1.0) * max(self.semi_axes)

    def normals(self, points: Array) -> Array:
        """(x/a², y/b², z/c²), normalised, (..., 3); at the centre the direction of the least axis."""
        scaled = points / np.array(self.semi_axes)
        return directions(scaled / np.array(self.semi_axes), otherwise=axis_of_least(self.semi_axes))

    def nearest(self, points: Array) -> Array:
        """The nearest point (..., 3) [m] by Newton's method, which converges from every point.

        The nearest point x to y has x_i = a_i² y_i / (a_i² + t), where p(t) = x / a has length one. 1/|p(t)| is concave
        and growing for t > −min a², so Newton's method on 1/|p| − 1 climbs to its root from the left without ever
        passing it (the secular equation of trust regions: Conn, Gould and Toint, Trust-Region Methods, 2000, 7.3).
        Each a_i |y_i| − a_i² is left of the root. s = t + min a² is what is iterated, for the root may be near zero.

        Deep inside, on the plane across the least axis, there are two nearest points: OFF_THE_PLANE chooses one.
        """
        axes = np.array(self.semi_axes)
        least = int(np.argmin(axes))
        spread = axes**2 - axes[least] ** 2
        xp, floor = namespace(points), np.zeros(3)
        floor[least] = OFF_THE_PLANE * axes[least] ** 2
        scaled = xp.maximum(xp.abs(points) * axes, floor)

        def seen_from(root: Array) -> tuple[Array, ...]:
            shares = scaled / (root[..., None] + spread)
            return root, shares, lengths(shares)

        def nearer(root: Array, shares: Array, length: Array) -> tuple[Array, ...]:
            slope = lengths(shares / xp.sqrt(root[..., None] + spread)) ** 2
            return seen_from(xp.where(length > ENOUGH, root + (length - 1.0) * length**2 / slope, root))

        first = seen_from((scaled - spread).max(axis=-1))
        _, shares, length = repeated(first, lambda *state: state[2] > ENOUGH, nearer, MOST_PASSES)
        return xp.copysign(axes * shares / length[..., None], points)

    def sample(self, count: int, random: np.random.Generator) -> Array:
        """Points u of the unit sphere, stretched and kept in proportion to |(u_i / a_i)|, the growth of area there."""
        axes = np.array(self.semi_axes)

        def draw(number: int, random: np.random.Generator) -> tuple[Array, Array]:
            unit = directions(random.normal(size=(number, 3)), otherwise=axis_of_least(self.semi_axes))
            return unit * axes, lengths(unit / axes) * axes.min()

        return accepted(count, random, draw)

    def rings(self, count: int) -> Array:
        """Stretched circles of latitude (count + 1, 2 count, 3) [m]."""
        rings: Array = unit_sphere(count) * np.array(self.semi_axes)
        return rings
