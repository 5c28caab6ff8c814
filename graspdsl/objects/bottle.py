"""The bottle."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import ClassVar

import numpy as np
from pydantic import Field

from graspdsl.arrays import Array
from graspdsl.objects.facets import FINEST, HALF_TURN, Hull, stacked_hulls
from graspdsl.objects.mass import Solid, stacked_solid
from graspdsl.objects.shape import UPRIGHT, DescribedShape, Extent, Rounding, Size
from graspdsl.objects.surfaces.profile import Profile, rounded
from graspdsl.objects.surfaces.revolution import Revolution


class Bottle(DescribedShape):
    """A bottle of revolution: body, shoulder, neck."""

    name: ClassVar = "bottle"
    about: ClassVar = "a bottle of revolution"
    convex: ClassVar = False

    diameter: Size = Field(description="diameter of the body (m)", examples=[0.08])
    height: Size = Field(description="height of the whole (m)", examples=[0.22])
    neck_diameter: Size = Field(description="diameter of the neck (m)", examples=[0.03])
    body_height: Size = Field(description="height of the body below the shoulder (m)", examples=[0.13])
    neck_height: Size = Field(description="height of the neck above the shoulder (m)", examples=[0.04])
    shoulder: Rounding = Field(description="rounding of the shoulder (m)", examples=[0.015])
    edge: Rounding = Field(description="rounding of bottom and top (m)", examples=[0.008])

    @property
    def extent(self) -> Extent:
        """Full size along x, y, z [m]."""
        return (self.diameter, self.diameter, self.height)

    @property
    def axle(self) -> Extent:
        """z."""
        return UPRIGHT

    @property
    def solid(self) -> Solid:
        """Over its outline."""
        return stacked_solid(self._surface.profile)

    @cached_property
    def _surface(self) -> SmoothBottle:
        return SmoothBottle(**dict(self))

    def support(self, direction: Array) -> float:
        """As far as its outline reaches."""
        x, y, z = direction
        return self._surface.profile.reach(float(np.hypot(x, y)), float(z))

    def surface(self) -> SmoothBottle:
        """All of it."""
        return self._surface

    def hulls(self) -> tuple[Hull, ...]:
        """Slices, cut where the outline turns outwards."""
        return stacked_hulls(self._surface.profile.outline(HALF_TURN, FINEST))


@dataclass(frozen=True)
class SmoothBottle(Revolution):
    """A closed bottle along z, all lengths in m, the origin at half its height.

    The body is a cylinder up to ``body_height``, the neck one down from the top over ``neck_height``, the shoulder
    between them a cone. ``shoulder`` is the radius of the two roundings at the shoulder's ends, the lower one a bulge
    and the upper one a hollow; ``edge`` is that of the bottom's and the top's edge. Radius and slope are continuous
    all over. Not convex. ``level`` is the signed distance.
    """

    diameter: float
    height: float
    neck_diameter: float
    body_height: float
    neck_height: float
    shoulder: float
    edge: float

    @cached_property
    def profile(self) -> Profile:
        """Bottom, body, shoulder, neck and top, with four rounded corners [m]. Raises ValueError if they do not fit."""
        if self.neck_diameter >= self.diameter:
            raise ValueError("the neck is as wide as the body or wider")
        body, neck, low, high = self.diameter / 2, self.neck_diameter / 2, -self.height / 2, self.height / 2
        shoulder_ends = (body, low + self.body_height), (neck, high - self.neck_height)
        corners = ((0.0, low), (body, low), *shoulder_ends, (neck, high), (0.0, high))
        return rounded(corners, (self.edge, self.shoulder, self.shoulder, self.edge))
