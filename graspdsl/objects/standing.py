"""Does an object stand where it is put: statics, without any engine."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from functools import cache

import numpy as np

from graspdsl.angles import roll_pitch_yaw
from graspdsl.arrays import Array
from graspdsl.objects.shape import Shape
from graspdsl.objects.turned import Turned, posed, turned

STANDING = 5.0  # degrees by which an object that stands may tilt
NUDGE = 0.01  # rad by which what balances is pushed
STEPS = (0.02, 0.005, 0.001)  # rad
WAYS = 2.0 * np.pi * np.arange(16)[:, None] / 16  # rad, in which it may tip
DOWN = np.array([0.0, 0.0, -1.0])
DIGITS = 4  # of angles [rad] that a spec is to have
TINY = 1e-12
SLOPE = 1e-4  # of the height over the size, by an angle: what is less steep lies still


def fall_of(shape: Shape) -> float:
    """The angle [rad] by which a shape of even density tips when it is put upright on a table; 0 where it stands.

    A body at rest has its centre of mass at a height that is lowest among those of all orientations near by; the height
    over a table below it, in the direction d of the body's frame, is support(d) − d · centre. What is put down and
    nudged tips from there as long as its centre of mass sinks.
    """
    return max((math.acos(float(np.clip(-end[2], -1.0, 1.0))) for end in _ends(shape)), default=0.0)


def pose_at_rest(shape: Shape) -> str | None:
    """How a spec writes a pose in which a shape that tips stays as it is put down; None where none is found.

    That is as it lies when it has tipped, by angles; of what falls over ``lay-down`` where that will do.
    """
    whole = shape.shape if isinstance(shape, Turned) else shape
    if fall_of(shape) > math.radians(STANDING) and fall_of(posed(whole, "lay-down")) == 0.0:
        return "pose: lay-down"
    for end in _ends(shape):
        turn = _shortest_turn(end, DOWN) @ (shape.rotation if isinstance(shape, Turned) else np.eye(3))
        roll, pitch, yaw = (round(angle, DIGITS) + 0.0 for angle in roll_pitch_yaw(turn))
        if fall_of(turned(whole, (roll, pitch, yaw))) == 0.0:
            return f"pose: {{rpy: [{roll:g}, {pitch:g}, {yaw:g}]}}"
    return None


@cache
def _ends(shape: Shape) -> Sequence[Array]:
    """The directions (3,) that point down, in the body's frame, in which a shape comes to rest that is put down upright
    and nudged; none where it stays."""
    centre = shape.solid.centre

    def height(down: Array) -> float:
        return shape.support(down) - float(down @ centre)

    least = SLOPE * NUDGE * max(shape.extent)
    nudged = (down for down in _tipped(DOWN, NUDGE) if height(down) < height(DOWN) - least)
    return [_rest(height, down, max(shape.extent)) for down in nudged]


def _shortest_turn(one: Array, other: Array) -> Array:
    """The rotation (3, 3) that takes a direction (3,) to another by the shortest way."""
    axis = np.cross(one, other)
    length, cosine = float(np.linalg.norm(axis)), float(one @ other)
    if length < TINY:
        return np.eye(3) if cosine > 0.0 else np.diag([1.0, -1.0, -1.0])
    x, y, z = axis / length
    across = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    return np.asarray(np.eye(3) + length * across + (1.0 - cosine) * across @ across)


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
