"""Does an object stand where it is put: statics, without any engine."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from graspdsl.arrays import Array
from graspdsl.objects.shape import Shape

STANDING = 5.0  # degrees by which an object that stands may tilt
NUDGE = 0.01  # rad by which what balances is pushed
STEPS = (0.02, 0.005, 0.001)  # rad
WAYS = 2.0 * np.pi * np.arange(16)[:, None] / 16  # rad, in which it may tip
SLOPE = 1e-4  # of the height over the size, by an angle: what is less steep lies still


def fall_of(shape: Shape) -> float:
    """The angle [rad] by which a shape of even density tips when it is put upright on a table; 0 where it stands.

    A body at rest has its centre of mass at a height that is lowest among those of all orientations near by; the height
    over a table below it, in the direction d of the body's frame, is support(d) − d · centre. What is put down and
    nudged tips from there as long as its centre of mass sinks.
    """
    centre = shape.solid.centre

    def height(down: Array) -> float:
        return shape.support(down) - float(down @ centre)

    upright = np.array([0.0, 0.0, -1.0])
    least = SLOPE * NUDGE * max(shape.extent)
    nudged = (down for down in _tipped(upright, NUDGE) if height(down) < height(upright) - least)
    ends = [_rest(height, down, max(shape.extent)) for down in nudged]
    return max((math.acos(float(np.clip(end @ upright, -1.0, 1.0))) for end in ends), default=0.0)


def _rest(height: Callable[[Array], float], down: Array, size: float) -> Array:
    """The direction (3,) that points down, in the body's frame, when it has come to rest."""
    lowest = height(down)
    for step in STEPS:
        while True:
            tried = _tipped(down, step)
            heights = [height(direction) for direction in tried]
            best = int(np.argmin(heights))
            if heights[best] > lowest - SLOPE * step * size:
                break
            down, lowest = tried[best], heights[best]
    return down


def _tipped(down: Array, angle: float) -> Array:
    """A direction (3,) turned by an angle [rad] in each of the WAYS (16, 3)."""
    aside = np.cross(down, np.eye(3)[int(np.argmin(np.abs(down)))])
    aside /= np.linalg.norm(aside)
    tangents = np.cos(WAYS) * aside + np.sin(WAYS) * np.cross(down, aside)
    return np.asarray(math.cos(angle) * down + math.sin(angle) * tangents)
