"""How far an object leans from how it stood."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from graspdsl.arrays import Array
from graspdsl.objects.shape import Shape

UP = np.array([0.0, 0.0, 1.0])


@dataclass(frozen=True, slots=True)
class Standing:
    """An object at rest: what was up in its frame (3,) then; ``topples``: whether it matters how it stands; ``axle``:
    the axis (3,) in its frame about which it may roll where it lies on its round side."""

    up: Array
    topples: bool
    axle: Array | None = None

    @classmethod
    def of(cls, rotation: Array, shape: Shape, topples: bool = True) -> Standing:
        """That of an object of a shape whose body frame is turned by a rotation (3, 3). A ball never topples."""
        axle = np.array(shape.axle) if shape.lies_round else None
        return cls(rotation.T @ UP, topples and not shape.rolls, axle)

    def lean(self, rotation: Array) -> float:
        """The angle [rad] by which what was up is off the vertical in a rotation (3, 3), or an axle steeper or less so
        than it was; a ball may roll, and what floats may turn."""
        if not self.topples:
            return 0.0
        if self.axle is not None:
            now, then = (math.asin(float(np.clip(self.axle @ up, -1.0, 1.0))) for up in (rotation.T @ UP, self.up))
            return abs(now - then)
        up = rotation @ self.up
        return math.atan2(float(np.hypot(up[0], up[1])), float(up[2]))
