"""The bottle."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

from graspdsl.objects.surfaces.profile import Profile, rounded
from graspdsl.objects.surfaces.revolution import Revolution


@dataclass(frozen=True)
class Bottle(Revolution):
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
