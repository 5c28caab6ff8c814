"""The capsule, as models of others have it: no shape of a spec."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from graspdsl.arrays import Array
from graspdsl.objects.cylinder import RoundedCylinder
from graspdsl.objects.mass import Solid
from graspdsl.objects.shape import UPRIGHT, Extent, Shape


@dataclass(frozen=True)
class Capsule(Shape):
    """All points within ``radius`` [m] of a line of ``length`` [m] along z."""

    name: ClassVar = "capsule"

    radius: float
    length: float

    @property
    def extent(self) -> Extent:
        """Full size along x, y, z [m]."""
        return (2 * self.radius, 2 * self.radius, self.length + 2 * self.radius)

    @property
    def axle(self) -> Extent:
        """z."""
        return UPRIGHT

    @property
    def solid(self) -> Solid:
        """A cylinder of volume C and two halves of a ball of volume B, whose centres are 3r/8 beyond its ends:
        ∫ x² dV = C r²/4 + B r²/5, ∫ z² dV = C l²/12 + B (r²/5 + 3 r l/8 + l²/4)."""
        r, long = self.radius, self.length
        cylinder, ball = math.pi * r**2 * long, 4 / 3 * math.pi * r**3
        across = cylinder * r**2 / 4 + ball * r**2 / 5
        along = cylinder * long**2 / 12 + ball * (r**2 / 5 + 3 * r * long / 8 + long**2 / 4)
        return Solid(cylinder + ball, np.zeros(3), np.diag([across, across, along]))

    def support(self, direction: Array) -> float:
        """r |d| + l/2 |z|."""
        return self.radius * float(np.linalg.norm(direction)) + self.length / 2 * float(abs(direction[2]))

    def surface(self) -> RoundedCylinder:
        """A cylinder whose edges are half balls."""
        return RoundedCylinder(2 * self.radius, self.extent[2], self.radius)
