"""Shapes that a few numbers describe, each about the origin with its axis along z."""

from __future__ import annotations

from dataclasses import astuple, dataclass
from functools import cached_property

import numpy as np

from graspdsl.arrays import Array
from graspdsl.objects.surfaces.bottle import Bottle as BottleSurface
from graspdsl.objects.surfaces.profile import Profile

Extent = tuple[float, float, float]


@dataclass(frozen=True, slots=True)
class Cylinder:
    """A cylinder along z, diameter and height [m]; ``edge`` [m] rounds its edges where contacts float."""

    diameter: float
    height: float
    edge: float = 0.005

    @property
    def extent(self) -> Extent:
        """Full size along x, y, z [m]."""
        return (self.diameter, self.diameter, self.height)

    def support(self, direction: Array) -> float:
        """How far the shape reaches from its origin along a unit vector (3,) [m]."""
        x, y, z = direction
        return float(self.diameter / 2 * np.hypot(x, y) + self.height / 2 * abs(z))


@dataclass(frozen=True, slots=True)
class Sphere:
    """A sphere, diameter [m]."""

    diameter: float

    @property
    def extent(self) -> Extent:
        """Full size along x, y, z [m]."""
        return (self.diameter,) * 3

    def support(self, direction: Array) -> float:
        """How far the shape reaches from its origin along a unit vector (3,) [m]."""
        return self.diameter / 2 * float(np.linalg.norm(direction))


@dataclass(frozen=True, slots=True)
class Box:
    """A box, full size along x, y, z [m]."""

    size: Extent

    @property
    def extent(self) -> Extent:
        """Full size along x, y, z [m]."""
        return self.size

    def support(self, direction: Array) -> float:
        """How far the shape reaches from its origin along a unit vector (3,) [m]."""
        return float(np.abs(direction) @ np.array(self.size) / 2)


@dataclass(frozen=True, slots=True)
class Ellipsoid:
    """An ellipsoid, full size along x, y, z [m]."""

    size: Extent

    @property
    def extent(self) -> Extent:
        """Full size along x, y, z [m]."""
        return self.size

    def support(self, direction: Array) -> float:
        """How far the shape reaches from its origin along a unit vector (3,) [m]."""
        return float(np.linalg.norm(direction * np.array(self.size) / 2))


@dataclass(frozen=True, slots=True)
class Superquadric:
    """|x/a|^p + |y/b|^p + |z/c|^p = 1: full size (2a, 2b, 2c) [m], exponent p from a ball (2) to a box (10)."""

    size: Extent
    exponent: float

    @property
    def extent(self) -> Extent:
        """Full size along x, y, z [m]."""
        return self.size

    def support(self, direction: Array) -> float:
        """How far the shape reaches from its origin along a unit vector (3,) [m]: the dual norm, 1/p + 1/q = 1."""
        dual = self.exponent / (self.exponent - 1.0)
        return float(np.linalg.norm(direction * np.array(self.size) / 2, ord=dual))


@dataclass(frozen=True)
class Bottle:
    """A bottle of revolution along z: body, shoulder and neck [m]; ``shoulder`` and ``edge`` are roundings."""

    diameter: float
    height: float
    neck_diameter: float
    body_height: float
    neck_height: float
    shoulder: float
    edge: float

    @property
    def extent(self) -> Extent:
        """Full size along x, y, z [m]."""
        return (self.diameter, self.diameter, self.height)

    @cached_property
    def profile(self) -> Profile:
        """Half of the cut along its axis. Raises ValueError when the sizes do not go together."""
        return BottleSurface(*astuple(self)).profile

    def support(self, direction: Array) -> float:
        """How far the shape reaches from its origin along a unit vector (3,) [m]."""
        x, y, z = direction
        return self.profile.reach(float(np.hypot(x, y)), float(z))
