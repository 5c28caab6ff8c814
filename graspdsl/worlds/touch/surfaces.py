"""The surfaces of fingertips: normals, nearest points, where a load touches, where the taxels of a skin lie."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from typing import NamedTuple

import numpy as np

from graspdsl.angles import turned_by_angles
from graspdsl.arrays import Array
from graspdsl.basis.algebra import length
from graspdsl.hands.fingertips import CapsuleTip, EllipsoidTip, FingertipShape, SphereTip
from graspdsl.objects.ellipsoid import SmoothEllipsoid
from graspdsl.worlds.touch.intrinsic import capsule_contact, ellipsoid_contact, sphere_contact

MERIDIAN_SAMPLES = 2001


class Taxels(NamedTuple):
    """The taxels of a skin: points (t, 3) [m] on the surface, from the centre, and the area [m²] of each, (t,)."""

    points: Array
    areas: Array


class FingertipSurface(ABC):
    """A closed convex surface. Points (3,) [m] are from the centre of the shape, in the axes of the tip's link."""

    @abstractmethod
    def normal(self, point: Array) -> Array:
        """The outward unit normal (3,) at a point of the surface."""

    @abstractmethod
    def nearest(self, point: Array) -> Array:
        """The point of the surface nearest to any point."""

    @abstractmethod
    def contact(self, force: Array, moment: Array) -> Array:
        """The contact point (3,) of a load that the object puts on the tip, by intrinsic contact sensing.

        force (3,) [N], moment (3,) [N·m] about the centre. Raises ValueError when the force is zero.
        """

    def normals(self, points: Array) -> Array:
        """The outward unit normals (c, 3) at points (c, 3)."""
        return np.array([self.normal(point) for point in points])

    def contacts(self, forces: Array, moments: Array) -> Array:
        """The contact points (c, 3) of loads (c, 3) each."""
        return np.array([self.contact(*load) for load in zip(forces, moments, strict=True)])

    @abstractmethod
    def taxels(self, pitch: float) -> Taxels:
        """Taxels about ``pitch`` [m] apart, in rings about one axis."""


class SphereSurface(FingertipSurface):
    """A sphere of ``radius`` [m]."""

    def __init__(self, radius: float) -> None:
        self.radius = radius

    def normal(self, point: Array) -> Array:
        """The direction of the point."""
        return np.asarray(point / np.linalg.norm(point))

    def nearest(self, point: Array) -> Array:
        """The point of the sphere in the same direction; for the centre the one along x."""
        distance = float(np.linalg.norm(point))
        direction = point / distance if distance > 0.0 else np.array([1.0, 0.0, 0.0])
        return np.asarray(self.radius * direction)

    def contact(self, force: Array, moment: Array) -> Array:
        """See :func:`graspdsl.worlds.touch.intrinsic.sphere_contact`."""
        return sphere_contact(force, moment, self.radius)

    def normals(self, points: Array) -> Array:
        """The directions of the points."""
        return np.asarray(points / length(points)[:, None])

    def contacts(self, forces: Array, moments: Array) -> Array:
        """The same of many at once."""
        return sphere_contact(forces, moments, self.radius)

    def taxels(self, pitch: float) -> Taxels:
        """Rings about z."""
        angles = np.linspace(0.0, math.pi, MERIDIAN_SAMPLES)
        return _rings(self.radius * np.sin(angles), self.radius * np.cos(angles), (1.0, 1.0), pitch)


class EllipsoidSurface(FingertipSurface):
    """An ellipsoid with ``semi_axes`` (3,) [m] along the columns of ``axes`` (3, 3)."""

    def __init__(self, semi_axes: tuple[float, float, float], axes: Array) -> None:
        self.semi_axes, self._axes = np.array(semi_axes), axes
        self._surface = SmoothEllipsoid(semi_axes)

    def normal(self, point: Array) -> Array:
        """The direction of the gradient, A⁻² c."""
        return self._axes @ self._surface.normals(self._axes.T @ point)

    def nearest(self, point: Array) -> Array:
        """See :meth:`graspdsl.objects.ellipsoid.SmoothEllipsoid.nearest`."""
        return self._axes @ self._surface.nearest(self._axes.T @ point)

    def contact(self, force: Array, moment: Array) -> Array:
        """See :func:`graspdsl.worlds.touch.intrinsic.ellipsoid_contact`."""
        return self._axes @ ellipsoid_contact(self._axes.T @ force, self._axes.T @ moment, self.semi_axes)

    def taxels(self, pitch: float) -> Taxels:
        """Rings about the third axis, their distances those of an ellipsoid round about it."""
        angles = np.linspace(0.0, math.pi, MERIDIAN_SAMPLES)
        a, b, c = self.semi_axes.tolist()
        width = math.sqrt(a * b)
        points, areas = _rings(width * np.sin(angles), c * np.cos(angles), (a / width, b / width), pitch)
        return Taxels(points @ self._axes.T, areas)


class CapsuleSurface(FingertipSurface):
    """All points at ``radius`` [m] from a segment of ``length`` [m] along the third column of ``axes`` (3, 3)."""

    def __init__(self, radius: float, length: float, axes: Array) -> None:
        self.radius, self.length, self._axes = radius, length, axes

    def _inner(self, point: Array) -> Array:
        """The point of the segment nearest to a point."""
        axis = self._axes[:, 2]
        height = max(-0.5 * self.length, min(0.5 * self.length, float(axis @ point)))
        return np.asarray(height * axis)

    def normal(self, point: Array) -> Array:
        """The direction from the nearest point of the segment."""
        outward = point - self._inner(point)
        return np.asarray(outward / np.linalg.norm(outward))

    def nearest(self, point: Array) -> Array:
        """Along the shortest way from the segment; for points of the segment across it."""
        inner = self._inner(point)
        distance = float(np.linalg.norm(point - inner))
        direction = (point - inner) / distance if distance > 0.0 else self._axes[:, 0]
        return np.asarray(inner + self.radius * direction)

    def contact(self, force: Array, moment: Array) -> Array:
        """See :func:`graspdsl.worlds.touch.intrinsic.capsule_contact`."""
        return self._axes @ capsule_contact(self._axes.T @ force, self._axes.T @ moment, self.radius, self.length)

    def taxels(self, pitch: float) -> Taxels:
        """Rings about the axis."""
        angles = np.linspace(0.0, math.pi, MERIDIAN_SAMPLES)
        heights = self.radius * np.cos(angles) + 0.5 * self.length * np.sign(np.cos(angles))
        points, areas = _rings(self.radius * np.sin(angles), heights, (1.0, 1.0), pitch)
        return Taxels(points @ self._axes.T, areas)


def fingertip_surface(shape: FingertipShape) -> FingertipSurface:
    """The surface of a hand file's fingertip."""
    match shape:
        case SphereTip():
            return SphereSurface(shape.radius)
        case EllipsoidTip():
            return EllipsoidSurface(shape.semi_axes, turned_by_angles(shape.rpy))
        case CapsuleTip():
            return CapsuleSurface(shape.radius, shape.length, frame_about(np.array(shape.axis)))


def frame_about(axis: Array) -> Array:
    """A right-handed frame (3, 3) whose third column is along ``axis``."""
    third = axis / np.linalg.norm(axis)
    first = np.cross(third, np.eye(3)[int(np.argmin(np.abs(third)))])
    first /= np.linalg.norm(first)
    return np.column_stack([first, np.cross(third, first), third])


def _rings(widths: Array, heights: Array, stretch: tuple[float, float], pitch: float) -> Taxels:
    """Taxels on rings about z, evenly along the meridian (widths, heights) and evenly along each ring.

    Rings are ellipses with semi-axes ``stretch`` times their width.
    """
    travelled = np.concatenate([[0.0], np.cumsum(np.hypot(np.diff(widths), np.diff(heights)))])
    count = max(2, round(float(travelled[-1]) / pitch))
    spacing = float(travelled[-1]) / count
    middles = (np.arange(count) + 0.5) * spacing
    turn = np.linspace(0.0, 2.0 * math.pi, MERIDIAN_SAMPLES)
    unit = np.column_stack([stretch[0] * np.cos(turn), stretch[1] * np.sin(turn)])
    around = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(unit, axis=0), axis=1))])
    points, areas = [], []
    for row, (width, height) in enumerate(
        zip(np.interp(middles, travelled, widths), np.interp(middles, travelled, heights), strict=True)
    ):
        perimeter = float(around[-1]) * width
        number = max(3, round(perimeter / pitch))
        places = (np.arange(number) + 0.5 * (row % 2)) / number * around[-1]
        angles = np.interp(places, around, turn)
        ring = [stretch[0] * width * np.cos(angles), stretch[1] * width * np.sin(angles), np.full(number, height)]
        points.append(np.column_stack(ring))
        areas.append(np.full(number, spacing * perimeter / number))
    return Taxels(np.concatenate(points), np.concatenate(areas))
