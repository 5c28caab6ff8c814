"""The cylinder, with sharp edges where it collides and with rounded ones where contacts float on it."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import ClassVar

import numpy as np
from pydantic import Field

from graspdsl.arrays import Array, Flags
from graspdsl.objects.facets import HALF_TURN, Hull, stacked_hulls
from graspdsl.objects.mass import Solid
from graspdsl.objects.shading import Shaded
from graspdsl.objects.shape import UPRIGHT, DescribedShape, Extent, Rounding, Size
from graspdsl.objects.surfaces.profile import Profile, rounded
from graspdsl.objects.surfaces.revolution import Revolution


class Cylinder(DescribedShape):
    """An upright cylinder."""

    name: ClassVar = "cylinder"
    about: ClassVar = "an upright cylinder"
    rests: ClassVar = True
    floating_only: ClassVar = ("edge",)

    diameter: Size = Field(description="diameter (m), 0.005 to 2", examples=[0.10])
    height: Size = Field(description="height (m), 0.005 to 2", examples=[0.20])
    edge: Rounding = Field(default=0.005, description="radius (m) that rounds the edges where contacts float")

    @property
    def extent(self) -> Extent:
        """Full size along x, y, z [m]."""
        return (self.diameter, self.diameter, self.height)

    @property
    def primitive(self) -> tuple[str, tuple[float, ...]]:
        """A cylinder of a radius and half a height."""
        return "cylinder", (self.diameter / 2, self.height / 2)

    @property
    def axle(self) -> Extent:
        """z."""
        return UPRIGHT

    @property
    def solid(self) -> Solid:
        """V = π d² h / 4, ∫ x² dV = V d² / 16, ∫ z² dV = V h² / 12."""
        across, along = self.diameter**2 / 16, self.height**2 / 12
        volume = math.pi / 4 * self.diameter**2 * self.height
        return Solid(volume, np.zeros(3), volume * np.diag([across, across, along]))

    def support(self, direction: Array) -> float:
        """d/2 √(x² + y²) + h/2 |z|."""
        x, y, z = direction
        return float(self.diameter / 2 * np.hypot(x, y) + self.height / 2 * abs(z))

    def surface(self) -> RoundedCylinder:
        """All of it, its edges rounded."""
        return RoundedCylinder(self.diameter, self.height, self.edge)

    def facets(self) -> tuple[Shaded, ...]:
        """Its surface, with edges that go with any size."""
        edge = min(self.edge, self.diameter / 4, self.height / 4)
        surface = RoundedCylinder(self.diameter, self.height, edge)
        mesh = surface.mesh(HALF_TURN)
        return (Shaded(mesh.vertices, surface.normals(mesh.vertices), mesh.faces),)

    def hulls(self) -> tuple[Hull, ...]:
        """A prism of many sides."""
        radius, top = self.diameter / 2, self.height / 2
        return stacked_hulls(np.array([(0.0, -top), (radius, -top), (radius, top), (0.0, top)]))

    def inside(self) -> Callable[[Array], Flags]:
        """Between its ends, nearer to its axis than the radius."""
        half = np.array([self.diameter / 2, self.height / 2])
        return lambda points: np.array((_around_axis(points) < half).all(axis=-1))


def _around_axis(points: Array) -> Array:
    """How far points (..., 3) are from the z axis, and from the plane across it, (..., 2)."""
    return np.stack([np.hypot(points[..., 0], points[..., 1]), np.abs(points[..., 2])], axis=-1)


@dataclass(frozen=True)
class RoundedCylinder(Revolution):
    """A cylinder along z, diameter and height in m, its two edges rounded to the radius ``edge`` [m].

    An edge of half the diameter gives half spheres for ends. ``level`` is the signed distance.
    """

    diameter: float
    height: float
    edge: float

    @cached_property
    def profile(self) -> Profile:
        """A rectangle with two rounded corners [m]."""
        radius, top = self.diameter / 2, self.height / 2
        return rounded(((0.0, -top), (radius, -top), (radius, top), (0.0, top)), (self.edge,) * 2)
