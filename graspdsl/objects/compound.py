"""Shapes put together from rounded, tapering parts: bottles as they stand in a kitchen."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cache, cached_property
from typing import ClassVar

import numpy as np

from graspdsl.angles import turned_by_angles
from graspdsl.arrays import Array
from graspdsl.objects.facets import FINEST, HALF_TURN, Hull, stacked_facets, stacked_hulls
from graspdsl.objects.mass import Solid, joined, stacked_solid
from graspdsl.objects.shading import Shaded
from graspdsl.objects.shape import Extent, Shape
from graspdsl.objects.surfaces.profile import Pair, Profile, rounded


@dataclass(frozen=True)
class Loft(Shape):
    """Sections along z: at each height |x/ρ|^n + |y/(wρ)|^n ≤ 1, with half width ρ(z) [m] along x.

    ``corners`` are the (ρ, z) [m] of the outline from the bottom to the top, each rounded by its radius in
    ``roundings`` [m]; ``width`` w (1) is the size along y over that along x; ``exponent`` n (1) goes from an ellipse
    (2) to nearly a rectangle (10).
    """

    name: ClassVar = "loft"
    edged: ClassVar = True

    corners: tuple[Pair, ...]
    roundings: tuple[float, ...]
    width: float = 1.0
    exponent: float = 2.0

    @cached_property
    def profile(self) -> Profile:
        """The rounded outline (ρ, z), from axis to axis. Raises ValueError when the roundings do not fit."""
        (_, low), (_, high) = self.corners[0], self.corners[-1]
        return rounded(((0.0, low), *self.corners, (0.0, high)), self.roundings)

    @property
    def extent(self) -> Extent:
        """Full size along x, y, z [m]."""
        return _extent(self)

    @property
    def solid(self) -> Solid:
        """Over its outline."""
        return stacked_solid(self.profile, self.width, self.exponent)

    def facets(self) -> tuple[Shaded, ...]:
        """All of it."""
        return (stacked_facets(self.profile, self.width, self.exponent),)

    def hulls(self) -> tuple[Hull, ...]:
        """Slices, cut where the outline turns outwards."""
        return stacked_hulls(self.profile.outline(HALF_TURN, FINEST), self.width, self.exponent)

    def support(self, direction: Array) -> float:
        """How far the part reaches from its origin along a unit vector (3,) [m]."""
        dual = self.exponent / (self.exponent - 1.0)
        x, y, z = direction
        level = np.linalg.norm([x, self.width * y], ord=dual)
        length = math.hypot(level, z)
        return length * self.profile.reach(float(level) / length, float(z) / length)


@dataclass(frozen=True, slots=True)
class Placed:
    """A part of a compound: its origin at ``at`` (3,) [m], turned by roll, pitch and yaw [rad], as in a URDF."""

    part: Shape
    at: Extent
    rpy: Extent = (0.0, 0.0, 0.0)

    @property
    def rotation(self) -> Array:
        """The part's axes in the frame of the compound (3, 3): about x, then y, then z of that frame."""
        return _turned(self.rpy)

    def support(self, direction: Array) -> float:
        """How far the part reaches from the compound's origin along a unit vector (3,) [m]."""
        return float(direction @ np.array(self.at)) + self.part.support(self.rotation.T @ direction)


@dataclass(frozen=True)
class Compound(Shape):
    """Parts that touch and do not overlap; the origin is on the axis of the whole, at half its height."""

    name: ClassVar = "compound"
    edged: ClassVar = True
    convex: ClassVar = False

    parts: tuple[Placed, ...]

    @cached_property
    def extent(self) -> Extent:
        """Full size along x, y, z [m]."""
        return _extent(self)

    @property
    def solid(self) -> Solid:
        """Its parts as one."""
        return joined(placed.part.solid.placed(placed.rotation, np.array(placed.at)) for placed in self.parts)

    def facets(self) -> tuple[Shaded, ...]:
        """Those of all parts."""
        each = ((placed, part) for placed in self.parts for part in placed.part.facets())
        return tuple(part.placed(placed.rotation, np.array(placed.at)) for placed, part in each)

    def hulls(self) -> tuple[Hull, ...]:
        """Those of all parts, without margins, since a compound has one in common."""
        each = ((placed, hull) for placed in self.parts for hull in _sharp(placed.part))
        return tuple(hull.placed(placed.rotation, np.array(placed.at)) for placed, hull in each)

    def support(self, direction: Array) -> float:
        """How far the shape reaches from its origin along a unit vector (3,) [m]."""
        return max(placed.support(direction) for placed in self.parts)


class Found(Compound):
    """A compound from elsewhere: its axes mean nothing, so that its longest extent is its major axis."""

    upright: ClassVar = False


_turned = cache(turned_by_angles)  # asked for as often as how far a part reaches


def _sharp(part: Shape) -> tuple[Hull, ...]:
    hulls = part.hulls()
    return Shape.hulls(part) if any(hull.margin for hull in hulls) else hulls


def _extent(shape: Shape) -> Extent:
    x, y, z = (shape.support(axis) + shape.support(-axis) for axis in np.eye(3))
    return (x, y, z)


def standing(parts: Sequence[Placed]) -> Compound:
    """The compound of parts whose heights are counted from the lowest point of the whole, on the axis of the whole."""
    return Compound(_moved(parts, (0.0, 0.0, -Compound(tuple(parts)).extent[2] / 2)))


def centred(parts: Sequence[Placed]) -> Compound:
    """The compound of parts from elsewhere, about the centre of its bounding box."""
    whole = Compound(tuple(parts))
    x, y, z = ((whole.support(-axis) - whole.support(axis)) / 2 for axis in np.eye(3))
    return Found(_moved(parts, (x, y, z)))


def _moved(parts: Sequence[Placed], by: Extent) -> tuple[Placed, ...]:
    x, y, z = by
    return tuple(replace(p, at=(p.at[0] + x, p.at[1] + y, p.at[2] + z)) for p in parts)
