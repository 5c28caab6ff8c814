"""Rotations in exponential coordinates: (..., 3) vectors along the axis, as long as the angle [rad]."""

from __future__ import annotations

import numpy as np

from graspdsl.arrays import Array, namespace, packed, product
from graspdsl.basis.algebra import length, skew

SMALL = 1e-8


def exponential(vectors: Array) -> Array:
    """exp([v]×) by Rodrigues' formula, (..., 3, 3)."""
    xp, angles = namespace(vectors), length(vectors)[..., None, None]
    small = angles < SMALL
    safe = xp.where(small, 1.0, angles)
    first = xp.where(small, 1.0, xp.sin(safe) / safe)
    second = xp.where(small, 0.5, (1.0 - xp.cos(safe)) / safe**2)
    cross = skew(vectors)
    return np.eye(3) + first * cross + second * product(cross, cross)


def logarithm(rotations: Array) -> Array:
    """The exponential coordinates (..., 3) of rotations (..., 3, 3), angle 0…π, through the unit quaternion."""
    xp, m = namespace(rotations), rotations
    a, b, c = m[..., 0, 0], m[..., 1, 1], m[..., 2, 2]
    x, y, z = m[..., 2, 1], m[..., 0, 2], m[..., 1, 0]
    u, v, w = m[..., 1, 2], m[..., 2, 0], m[..., 0, 1]
    # Four forms of one quaternion, each good where its leading part, on the diagonal, is large.
    forms = packed(
        *(1.0 + a + b + c, x - u, y - v, z - w),
        *(x - u, 1.0 + a - b - c, z + w, y + v),
        *(y - v, z + w, 1.0 - a + b - c, x + u),
        *(z - w, y + v, x + u, 1.0 - a - b + c),
    ).reshape(*m.shape[:-2], 4, 4)
    leading = forms.diagonal(axis1=-2, axis2=-1).argmax(axis=-1)
    quaternion = xp.take_along_axis(forms, leading[..., None, None], axis=-2)[..., 0, :]
    quaternion = quaternion / length(quaternion)[..., None]
    quaternion = xp.where(quaternion[..., :1] < 0.0, -quaternion, quaternion)
    part = quaternion[..., 1:]
    sine = length(part)[..., None]
    angle = 2.0 * xp.arctan2(sine, quaternion[..., :1])
    return xp.where(sine < SMALL, 2.0, angle / xp.where(sine < SMALL, 1.0, sine)) * part


def turned(by: Array, vectors: Array) -> Array:
    """The coordinates (..., 3) of the rotation ``vectors`` followed by the rotation ``by``, in fixed axes."""
    return logarithm(product(exponential(by), exponential(vectors)))


def turn_between(end: Array, start: Array) -> Array:
    """The rotation (..., 3), in fixed axes, that takes ``start`` to ``end``: log(exp(end) exp(start)ᵀ)."""
    return logarithm(product(exponential(end), namespace(start).swapaxes(exponential(start), -1, -2)))
