"""The superquadric: from an ellipsoid (exponent 2) to nearly a box (exponent 10)."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from pydantic import Field

from graspdsl.arrays import Array, Flags, namespace, repeated
from graspdsl.objects.facets import Hull, round_hull
from graspdsl.objects.mass import Solid, dirichlet, symmetric
from graspdsl.objects.shape import DescribedShape, Extent, Sizes
from graspdsl.objects.surfaces.mesh import unit_sphere
from graspdsl.objects.surfaces.sampling import accepted
from graspdsl.objects.surfaces.surface import Surface
from graspdsl.objects.surfaces.vectors import axis_of_least, directions, dot, largest, lengths
from graspdsl.places.fields import Number

EPSILON = float(np.finfo(np.float64).eps)
ENOUGH = 1.0 + 4.0 * EPSILON
MOST_PASSES = 100


class Superquadric(DescribedShape):
    """|x/a|^p + |y/b|^p + |z/c|^p = 1: between a ball and a box."""

    name: ClassVar = "superquadric"
    about: ClassVar = "a superquadric"
    upright: ClassVar = False

    size: Sizes = Field(description="full size along x, y and z (m), 0.005 to 2 each", examples=[[0.10, 0.12, 0.16]])
    exponent: Number = Field(
        ge=2.0, le=10.0, description="exponent p (1), from 2, an ellipsoid, to 10, nearly a box", examples=[3.0]
    )

    @property
    def extent(self) -> Extent:
        """Full size along x, y, z [m]."""
        return self.size

    @property
    def solid(self) -> Solid:
        """By Dirichlet's integral."""
        volume = math.prod(self.size) * dirichlet(self.exponent, 1, 1, 1)
        share = dirichlet(self.exponent, 3, 1, 1) / dirichlet(self.exponent, 1, 1, 1) / 4
        return symmetric(volume, self.size, share)

    def support(self, direction: Array) -> float:
        """The dual norm, 1/p + 1/q = 1."""
        dual = self.exponent / (self.exponent - 1.0)
        return float(np.linalg.norm(direction * np.array(self.size) / 2, ord=dual))

    def surface(self) -> SmoothSuperquadric:
        """All of it."""
        x, y, z = self.size
        return SmoothSuperquadric((x / 2, y / 2, z / 2), self.exponent)

    def hulls(self) -> tuple[Hull, ...]:
        """One, with a margin that rounds it."""
        return (round_hull(self.size, self.exponent, self.surface()),)


@dataclass(frozen=True)
class SmoothSuperquadric(Surface):
    """|x/a|^p + |y/b|^p + |z/c|^p = 1 with semi axes (a, b, c) in m, half of the full size, exponent p from 2 to 10.

    In the formulas below u = (x/a, y/b, z/c), and |u|_p = (Σ |u_i|^p)^(1/p) is the gauge of a point.
    """

    semi_axes: tuple[float, float, float]
    exponent: float

    def __post_init__(self) -> None:
        if not min(self.semi_axes) > 0.0:
            raise ValueError(f"the semi axes of a superquadric must be positive, not {self.semi_axes}")
        if not 2.0 <= self.exponent <= 10.0:
            raise ValueError(f"the exponent of a superquadric must be from 2 to 10, not {self.exponent}")

    @property
    def extent(self) -> tuple[float, float, float]:
        """Full size along x, y, z [m]."""
        a, b, c = self.semi_axes
        return (2 * a, 2 * b, 2 * c)

    def level(self, points: Array) -> Array:
        """(|u|_p − 1) √(a² + b² + c²) [m], (...)."""
        return (self._gauge(points / np.array(self.semi_axes)) - 1.0) * float(np.linalg.norm(self.semi_axes))

    def normals(self, points: Array) -> Array:
        """sign(u_i) |u_i|^(p−1) / a_i, normalised, (..., 3); at the centre the direction of the least axis."""
        xp, axes = namespace(points), np.array(self.semi_axes)
        scaled = xp.abs(points) / axes
        size = largest(scaled)[..., None]
        steepness = (scaled / xp.where(size > 0.0, size, 1.0)) ** (self.exponent - 1.0)
        return directions(xp.copysign(steepness / axes, points), otherwise=axis_of_least(self.semi_axes))

    def nearest(self, points: Array) -> Array:
        """The nearest point (..., 3) [m] by Newton's method, which converges from every point.

        For y outside, with v = |y/a|, the nearest point is the u(λ) of length |u|_p = 1 among the solutions of

            u_i + (λ/a_i²) u_i^(p−1) = v_i,    λ ≥ 0.

        1/u_i is concave in λ and so, for p ≥ 2, is 1/|u|_p (a mean of the 1/u_i that is concave and growing): Newton's
        method on 1/|u(λ)|_p − 1 climbs from λ = 0 to its root without ever passing it. For each λ, u_i is the root of
        a convex and growing function, to which Newton's method descends from any bound above it.

        A point inside is first put, along the normal, on the tangent plane where the ray from the centre through it
        meets the surface. Its result is the nearest point up to the square of its depth.
        """
        xp, axes, outside = namespace(points), np.array(self.semi_axes), self._put_outside(points)
        values = xp.abs(outside) / axes

        def nearer(multiplier: Array, feet: Array, gauge: Array) -> tuple[Array, Array, Array]:
            far = gauge > ENOUGH
            powers = feet ** (self.exponent - 2.0)
            weights = powers / (axes**2 + (self.exponent - 1.0) * multiplier[..., None] * powers)
            slope = dot(feet**2 * powers, weights)
            multiplier = xp.where(far, multiplier + (gauge - 1.0) * gauge**self.exponent / slope, multiplier)
            feet = xp.where(far[..., None], self._roots(multiplier[..., None] / axes**2, values, feet), feet)
            return multiplier, feet, xp.where(far, self._gauge(feet), gauge)

        first = (xp.zeros_like(values[..., 0]), values, self._gauge(values))
        _, feet, gauge = repeated(first, lambda *state: state[2] > ENOUGH, nearer, MOST_PASSES)
        return xp.copysign(axes * (feet / gauge[..., None]), outside)

    def sample(self, count: int, random: np.random.Generator) -> Array:
        """Points of a cube, drawn to the surface along rays and kept in proportion to the growth of area there.

        A patch dC of the cube max |c_i| = 1 becomes one of area a b c κ³ |(|u_i|^(p−1) / a_i)| dC at u = κ c with
        κ = 1/|c|_p, and that is at most a b c / min(a, b, c) dC.
        """
        axes = np.array(self.semi_axes)

        def draw(number: int, random: np.random.Generator) -> tuple[Array, Array]:
            cube = random.uniform(-1.0, 1.0, (number, 3))
            cube[np.arange(number), random.integers(3, size=number)] = np.sign(random.uniform(-1.0, 1.0, number))
            unit = cube / self._gauge(cube)[:, None]
            growth = lengths(np.abs(unit) ** (self.exponent - 1.0) / axes) / self._gauge(cube) ** 3
            return unit * axes, growth * axes.min()

        return accepted(count, random, draw)

    def rings(self, count: int) -> Array:
        """The unit sphere's circles of latitude, drawn to the surface along rays: (count + 1, 2 count, 3) [m]."""
        sphere = unit_sphere(count)
        rings: Array = sphere / self._gauge(sphere)[..., None] * np.array(self.semi_axes)
        return rings

    def _gauge(self, scaled: Array) -> Array:
        """|u|_p, (...)."""
        xp, size = namespace(scaled), largest(scaled)
        powers = (xp.abs(scaled) / xp.where(size > 0.0, size, 1.0)[..., None]) ** self.exponent
        return size * (powers[..., 0] + powers[..., 1] + powers[..., 2]) ** (1.0 / self.exponent)

    def _put_outside(self, points: Array) -> Array:
        """Points outside as they are, those inside on a tangent plane nearby, (..., 3)."""
        xp, axes, normals = namespace(points), np.array(self.semi_axes), self.normals(points)
        gauge = self._gauge(points / axes)
        feet = xp.where(
            gauge[..., None] > 0.0,
            points / xp.where(gauge > 0.0, gauge, 1.0)[..., None],
            axis_of_least(self.semi_axes) * axes,
        )
        depth = xp.where(gauge < 1.0, dot(feet - points, normals), 0.0)
        return points + depth[..., None] * normals

    def _roots(self, slopes: Array, values: Array, above: Array) -> Array:
        """The u ≤ ``above`` with u + m u^(p−1) = v for slopes m ≥ 0 and values v ≥ 0, (..., 3)."""
        xp = namespace(values)

        def seen_from(u: Array) -> tuple[Array, Array, Array, Flags]:
            steep = slopes * u ** (self.exponent - 2.0)
            excess = u + steep * u - values
            return u, steep, excess, excess > 4.0 * EPSILON * values

        def nearer(u: Array, steep: Array, excess: Array, unfinished: Flags) -> tuple[Array, Array, Array, Flags]:
            lower = xp.where(unfinished, u - excess / (1.0 + (self.exponent - 1.0) * steep), u)
            lower, steep, excess, unfinished = seen_from(lower)
            return lower, steep, excess, unfinished & (lower < u)  # where it no longer descends, all is rounding

        steepest = (values / xp.where(slopes > 0.0, slopes, 1.0)) ** (1.0 / (self.exponent - 1.0))
        first = xp.where(slopes > 0.0, xp.minimum(above, steepest), values)
        return repeated(seen_from(first), lambda *state: state[3], nearer, MOST_PASSES)[0]
