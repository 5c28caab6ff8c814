"""Fingertip shapes in hand files: convex surfaces that a load cell or a skin locates contacts on."""

from __future__ import annotations

import math
from typing import Annotated

import numpy as np
from pydantic import AfterValidator, Field

from graspdsl.angles import turned_by_angles
from graspdsl.arrays import Array
from graspdsl.places.fields import Metres, Model, Number, Unit, exactly, fault

Size = Annotated[Metres, Field(gt=0.0, le=1.0)]
Coordinate = Annotated[Metres, Field(ge=-2.0, le=2.0)]
Place = Annotated[tuple[Coordinate, Coordinate, Coordinate], exactly(3, "[x, y, z]: a place (m)")]
Angle = Annotated[Number, Unit("rad"), Field(ge=-2 * math.pi, le=2 * math.pi)]
Angles = Annotated[tuple[Angle, Angle, Angle], exactly(3, "[roll, pitch, yaw]: three angles (rad)")]


def _with_a_length(direction: tuple[float, float, float]) -> tuple[float, float, float]:
    if not 1e-6 < max(map(abs, direction)) < 1e6:
        raise fault("zero-axis", "a direction is needed here", "for example [1, 0, 0]")
    return direction


Directed = Annotated[
    tuple[Number, Number, Number], exactly(3, "[x, y, z]: a direction"), AfterValidator(_with_a_length)
]


class SphereTip(Model):
    """A sphere, centred at ``centre`` in the frame of the fingertip's link [m]."""

    centre: Place = (0.0, 0.0, 0.0)
    radius: Size


class EllipsoidTip(Model):
    """An ellipsoid with semi-axes [m] along the axes of a frame that ``rpy`` [rad] turns from the link's."""

    centre: Place = (0.0, 0.0, 0.0)
    semi_axes: Annotated[tuple[Size, Size, Size], exactly(3, "[a, b, c]: three lengths (m)")]
    rpy: Angles = (0.0, 0.0, 0.0)


class CapsuleTip(Model):
    """A capsule: all points within ``radius`` of a segment of ``length`` [m] about ``centre``, along ``axis``."""

    centre: Place = (0.0, 0.0, 0.0)
    radius: Size
    length: Size
    axis: Directed = (1.0, 0.0, 0.0)


FingertipShape = SphereTip | EllipsoidTip | CapsuleTip


def reach(shape: FingertipShape, directions: Array) -> Array:
    """How far (d,) [m] a shape reaches from the origin of its link along unit vectors (d, 3): max n · p over it."""
    match shape:
        case SphereTip():
            reached = np.full(len(directions), shape.radius)
        case EllipsoidTip():
            reached = np.linalg.norm(directions @ turned_by_angles(shape.rpy) * shape.semi_axes, axis=1)
        case CapsuleTip():
            axis = np.array(shape.axis) / np.linalg.norm(shape.axis)
            reached = shape.radius + shape.length / 2.0 * np.abs(directions @ axis)
    return np.asarray(directions @ np.array(shape.centre) + reached)


def directions_around(count: int) -> Array:
    """Unit vectors (count, 3), spread evenly on a spiral of golden angles."""
    heights = (2.0 * np.arange(count) + 1.0) / count - 1.0
    angles = np.pi * (3.0 - math.sqrt(5.0)) * np.arange(count)
    widths = np.sqrt(1.0 - heights**2)
    return np.column_stack([widths * np.cos(angles), widths * np.sin(angles), heights])
