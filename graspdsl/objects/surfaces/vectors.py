"""Lengths and directions of (..., 3) arrays, element by element, so that a batch gives what its points give alone."""

from __future__ import annotations

import numpy as np

from graspdsl.arrays import Array, namespace


def dot(a: Array, b: Array) -> Array:
    """a·b over the last axis, (...)."""
    result: Array = a[..., 0] * b[..., 0] + a[..., 1] * b[..., 1] + a[..., 2] * b[..., 2]
    return result


def lengths(vectors: Array) -> Array:
    """|v| over the last axis, (...)."""
    return namespace(vectors).sqrt(dot(vectors, vectors))


def rotated(vectors: Array, rotation: Array) -> Array:
    """R v over the last axis for a rotation (3, 3), (..., 3)."""
    x, y, z = (vectors[..., axis, None] * rotation[:, axis] for axis in range(3))
    result: Array = x + y + z
    return result


def largest(vectors: Array) -> Array:
    """The largest of |x|, |y|, |z|, (...)."""
    xp = namespace(vectors)
    sizes = xp.abs(vectors)
    return xp.maximum(xp.maximum(sizes[..., 0], sizes[..., 1]), sizes[..., 2])


def directions(vectors: Array, otherwise: Array) -> Array:
    """v / |v|, (..., 3), also for the smallest numbers there are; ``otherwise`` (3,) in place of no vector at all."""
    xp, size = namespace(vectors), largest(vectors)[..., None]
    scaled = xp.where(size > 0.0, vectors / xp.where(size > 0.0, size, 1.0), otherwise)
    return scaled / lengths(scaled)[..., None]


def axis_of_least(sizes: tuple[float, float, float]) -> Array:
    """The unit vector (3,) along the least of three sizes: where the surface is nearest to the centre."""
    axis: Array = np.eye(3)[int(np.argmin(sizes))]
    return axis
