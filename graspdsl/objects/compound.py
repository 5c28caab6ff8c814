"""Shapes put together from rounded, tapering parts: bottles as they stand in a kitchen."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from graspdsl.arrays import Array
from graspdsl.objects.primitives import Box, Extent
from graspdsl.objects.surfaces.profile import Pair, Profile, rounded


@dataclass(frozen=True)
class Loft:
    """Sections along z: at each height |x/ρ|^n + |y/(wρ)|^n ≤ 1, with half width ρ(z) [m] along x.

    ``corners`` are the (ρ, z) [m] of the outline from the bottom to the top, each rounded by its radius in
    ``roundings`` [m]; ``width`` w (1) is the size along y over that along x; ``exponent`` n (1) goes from an ellipse
    (2) to nearly a rectangle (10).
    """

    corners: tuple[Pair, ...]
    roundings: tuple[float, ...]
    width: float = 1.0
    exponent: float = 2.0

    @cached_property
    def profile(self) -> Profile:
        """The rounded outline (ρ, z), from axis to axis. Raises ValueError when the roundings do not fit."""
        (_, low), (_, high) = self.corners[0], self.corners[-1]
        return rounded(((0.0, low), *self.corners, (0.0, high)), self.roundings)

    def support(self, direction: Array) -> float:
        """How far the part reaches from its origin along a unit vector (3,) [m]."""
        dual = self.exponent / (self.exponent - 1.0)
        x, y, z = direction
        level = np.linalg.norm([x, self.width * y], ord=dual)
        length = math.hypot(level, z)
        return length * self.profile.reach(float(level) / length, float(z) / length)


@dataclass(frozen=True, slots=True)
class Placed:
    """A part of a compound: its origin at ``at`` (3,) [m], turned by ``pitch`` [rad] about y."""

    part: Loft | Box
    at: Extent
    pitch: float = 0.0

    @property
    def rotation(self) -> Array:
        """The part's axes in the frame of the compound (3, 3)."""
        sin, cos = math.sin(self.pitch), math.cos(self.pitch)
        return np.array([[cos, 0.0, sin], [0.0, 1.0, 0.0], [-sin, 0.0, cos]])

    def support(self, direction: Array) -> float:
        """How far the part reaches from the compound's origin along a unit vector (3,) [m]."""
        return float(direction @ np.array(self.at)) + self.part.support(self.rotation.T @ direction)


@dataclass(frozen=True)
class Compound:
    """Parts that touch and do not overlap; the origin is on the axis of the whole, at half its height."""

    parts: tuple[Placed, ...]

    @cached_property
    def extent(self) -> Extent:
        """Full size along x, y, z [m]."""
        x, y, z = (self.support(axis) + self.support(-axis) for axis in np.eye(3))
        return (x, y, z)

    def support(self, direction: Array) -> float:
        """How far the shape reaches from its origin along a unit vector (3,) [m]."""
        return max(placed.support(direction) for placed in self.parts)


def standing(parts: Sequence[Placed]) -> Compound:
    """The compound of parts whose heights are counted from the lowest point of the whole."""
    middle = Compound(tuple(parts)).extent[2] / 2
    lowered = (replace(placed, at=(*placed.at[:2], placed.at[2] - middle)) for placed in parts)
    return Compound(tuple(lowered))
