"""The cylinder with rounded edges."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

from graspdsl.objects.surfaces.profile import Profile, rounded
from graspdsl.objects.surfaces.revolution import Revolution


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
