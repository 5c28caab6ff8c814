"""Rotations in exponential coordinates: (..., 3) vectors along the axis, as long as the angle [rad]."""

from __future__ import annotations

import numpy as np

from graspdsl.arrays import Array
from graspdsl.basis.algebra import length, skew

SMALL = 1e-8


def exponential(vectors: Array) -> Array:
    """exp([v]×) by Rodrigues' formula, (..., 3, 3)."""
    angles = length(vectors)[..., None, None]
    small = angles < SMALL
    safe = np.where(small, 1.0, angles)
    first = np.where(small, 1.0, np.sin(safe) / safe)
    second = np.where(small, 0.5, (1.0 - np.cos(safe)) / safe**2)
    cross = skew(vectors)
    result: Array = np.eye(3) + first * cross + second * (cross @ cross)
    return result


def logarithm(rotations: Array) -> Array:
    """The exponential coordinates (..., 3) of rotations (..., 3, 3), angle 0…π, through the unit quaternion."""
    m = rotations
    a, b, c = m[..., 0, 0], m[..., 1, 1], m[..., 2, 2]
    x, y, z = m[..., 2, 1], m[..., 0, 2], m[..., 1, 0]
    u, v, w = m[..., 1, 2], m[..., 2, 0], m[..., 0, 1]
    # Four forms of one quaternion, each good where its leading part, on the diagonal, is large.
    forms = np.empty((*m.shape[:-2], 4, 4))
    forms[..., 0, 0], forms[..., 1, 1] = 1.0 + a + b + c, 1.0 + a - b - c
    forms[..., 2, 2], forms[..., 3, 3] = 1.0 - a + b - c, 1.0 - a - b + c
    forms[..., 0, 1], forms[..., 0, 2], forms[..., 0, 3] = x - u, y - v, z - w
    forms[..., 1, 2], forms[..., 1, 3], forms[..., 2, 3] = z + w, y + v, x + u
    for row, column in ((1, 0), (2, 0), (3, 0), (2, 1), (3, 1), (3, 2)):
        forms[..., row, column] = forms[..., column, row]
    leading = forms.diagonal(axis1=-2, axis2=-1).argmax(axis=-1)
    quaternion = np.take_along_axis(forms, leading[..., None, None], axis=-2)[..., 0, :]
    quaternion = quaternion / length(quaternion)[..., None]
    quaternion = np.where(quaternion[..., :1] < 0.0, -quaternion, quaternion)
    part = quaternion[..., 1:]
    sine = length(part)[..., None]
    angle = 2.0 * np.arctan2(sine, quaternion[..., :1])
    scale = np.where(sine < SMALL, 2.0, angle / np.where(sine < SMALL, 1.0, sine))
    result: Array = scale * part
    return result


def turned(by: Array, vectors: Array) -> Array:
    """The coordinates (..., 3) of the rotation ``vectors`` followed by the rotation ``by``, in fixed axes."""
    return logarithm(exponential(by) @ exponential(vectors))


def turn_between(end: Array, start: Array) -> Array:
    """The rotation (..., 3), in fixed axes, that takes ``start`` to ``end``: log(exp(end) exp(start)ᵀ)."""
    return logarithm(exponential(end) @ np.swapaxes(exponential(start), -1, -2))
