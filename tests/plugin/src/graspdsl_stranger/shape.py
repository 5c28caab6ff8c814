"""A shape of a stranger's: the cup."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import ClassVar

import numpy as np
from pydantic import Field

from graspdsl.arrays import Array
from graspdsl.objects.mass import Solid, stacked_solid
from graspdsl.objects.shape import DescribedShape, Extent, Rounding, Size
from graspdsl.objects.surfaces.profile import Profile, rounded
from graspdsl.objects.surfaces.revolution import Revolution


class Cup(DescribedShape):
    """A truncated cone, as paper cups and plant pots are; the origin at half its height."""

    name: ClassVar = "cup"
    about: ClassVar = "a truncated cone"
    rests: ClassVar = True

    bottom: Size = Field(description="diameter of the bottom (m)", examples=[0.06])
    top: Size = Field(description="diameter of the top (m)", examples=[0.09])
    height: Size = Field(description="height (m)", examples=[0.11])
    edge: Rounding = Field(default=0.004, description="radius (m) that rounds the edges")

    @cached_property
    def _surface(self) -> RoundedCone:
        return RoundedCone(self.bottom, self.top, self.height, self.edge)

    @property
    def extent(self) -> Extent:
        """Full size along x, y, z [m]; where edges are rounded, the wider end is a little narrower than its corner."""
        return self._surface.extent

    @property
    def solid(self) -> Solid:
        """Over its outline."""
        return stacked_solid(self._surface.profile)

    def support(self, direction: Array) -> float:
        """As far as its outline reaches."""
        x, y, z = direction
        return self._surface.profile.reach(float(np.hypot(x, y)), float(z))

    def surface(self) -> RoundedCone:
        """All of it."""
        return self._surface


@dataclass(frozen=True)
class RoundedCone(Revolution):
    """A cone cut off level at both ends, diameters and height in m, its two edges rounded to the radius ``edge`` [m].

    ``level`` is the signed distance.
    """

    bottom: float
    top: float
    height: float
    edge: float

    @cached_property
    def profile(self) -> Profile:
        """A trapezium with two rounded corners [m]. Raises ValueError where they leave no room for each other."""
        low, high = -self.height / 2, self.height / 2
        corners = ((0.0, low), (self.bottom / 2, low), (self.top / 2, high), (0.0, high))
        return rounded(corners, (self.edge, self.edge))
