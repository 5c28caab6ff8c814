"""Shapes in another pose than the one they are described in: laid down, upside down, turned by angles."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import Annotated, Any, ClassVar, Literal

import numpy as np
from pydantic import Field

from graspdsl.angles import roll_pitch_yaw, turned_by_angles
from graspdsl.arrays import Array, Flags
from graspdsl.objects.facets import Hull
from graspdsl.objects.mass import Solid
from graspdsl.objects.shading import Shaded
from graspdsl.objects.shape import Extent, Shape
from graspdsl.objects.surfaces.surface import Surface
from graspdsl.objects.surfaces.vectors import rotated
from graspdsl.places.fields import Model, Number, Unit, exactly, form, forms

TURN = 6.3  # rad, a little more than a whole one
ROUNDING = 1e-15  # of sines and cosines: a quarter turn leaves what is along an axis along an axis
ALONG = np.array([0.0, 1.0, 0.0])  # where what is laid down points to: across the way of a hand without yaw

Angle = Annotated[Number, Unit("rad"), Field(ge=-TURN, le=TURN)]


class Angles(Model):
    """How an object is turned before it is put on the table."""

    rpy: Annotated[tuple[Angle, Angle, Angle], exactly(3, "[roll, pitch, yaw]: three angles (rad)")] = Field(
        description="rotation (rad) about x, then y, then z of the table, as roll, pitch and yaw in a URDF",
        examples=[[1.5708, 0.0, 0.0]],
    )


def _form_of(value: Any) -> str | None:
    if isinstance(value, str):
        return "word" if value in ("lay-down", "upside-down") else None
    return "angles" if isinstance(value, dict | Angles) else None


ObjectPose = Annotated[
    Annotated[Literal["lay-down", "upside-down"], form("word")] | Annotated[Angles, form("angles")],
    forms("lay-down, upside-down or {rpy: [roll, pitch, yaw]}", _form_of),
]


def posed(shape: Shape, pose: ObjectPose | None) -> Shape:
    """A shape in a pose. ``lay-down`` turns its major axis by the shortest way to y, ``upside-down`` it about x."""
    match pose:
        case Angles(rpy=rpy):
            return turned(shape, rpy)
        case "lay-down":
            return turned(shape, _laid_down(np.array(shape.major_axis)))
        case "upside-down":
            return turned(shape, (math.pi, 0.0, 0.0))
    return shape


def turned(shape: Shape, rpy: Extent) -> Shape:
    """A shape turned by roll, pitch and yaw [rad]; a ball as it is."""
    if shape.rolls:
        return shape
    return Turned(shape, rpy) if shape.edged else TurnedSmooth(shape, rpy)


def _laid_down(axis: Array) -> Extent:
    """The angles of the rotation that turns one of the axes of a frame to y: a half of that about their bisector."""
    middle = axis + ALONG
    middle /= np.linalg.norm(middle)
    about_it = 2.0 * np.outer(middle, middle) - np.eye(3)
    about_y = np.diag([-1.0, 1.0, -1.0])
    return roll_pitch_yaw(about_y @ about_it)


@dataclass(frozen=True)
class Turned(Shape):
    """A shape turned by roll, pitch and yaw [rad], about the centre of its bounding box as it then is.

    It collides as its convex parts, also where the shape as it was is one that engines have of their own.
    """

    name: ClassVar = "turned object"
    edged: ClassVar = True
    convex: ClassVar = False  # or not: its parts are looked at

    shape: Shape
    rpy: Extent

    @cached_property
    def rotation(self) -> Array:
        """The axes of the shape within the frame of the turned one (3, 3)."""
        rotation = turned_by_angles(self.rpy)
        rotation[np.abs(rotation) < ROUNDING] = 0.0
        return rotation

    @cached_property
    def at(self) -> Array:
        """The origin of the shape within the frame of the turned one (3,) [m]."""
        reach = [(self.shape.support(axis), self.shape.support(-axis)) for axis in self.rotation]
        return np.array([(back - ahead) / 2 for ahead, back in reach])

    @cached_property
    def extent(self) -> Extent:
        """Full size along x, y, z [m]."""
        x, y, z = (self.shape.support(axis) + self.shape.support(-axis) for axis in self.rotation)
        return (x, y, z)

    @property
    def solid(self) -> Solid:
        """That of the shape, turned."""
        return self.shape.solid.placed(self.rotation, self.at)

    def support(self, direction: Array) -> float:
        """That of the shape in the direction that it has there."""
        return float(direction @ self.at) + self.shape.support(direction @ self.rotation)

    @property
    def major_axis(self) -> Extent:
        """That of the shape, turned."""
        return self._turned(self.shape.major_axis)

    @property
    def axle(self) -> Extent | None:
        """That of the shape, turned."""
        return None if self.shape.axle is None else self._turned(self.shape.axle)

    def facets(self) -> tuple[Shaded, ...]:
        """Those of the shape, turned."""
        return tuple(part.placed(self.rotation, self.at) for part in self.shape.facets())

    def hulls(self) -> tuple[Hull, ...]:
        """Those of the shape, turned."""
        return tuple(hull.placed(self.rotation, self.at) for hull in self.shape.hulls())

    def inside(self) -> Callable[[Array], Flags]:
        """What is in the shape."""
        within = self.shape.inside()
        return lambda points: within((points - self.at) @ self.rotation)

    def _turned(self, axis: Extent) -> Extent:
        x, y, z = (self.rotation @ np.array(axis)).tolist()
        return (x, y, z)


class TurnedSmooth(Turned):
    """A shape without edges, turned."""

    edged: ClassVar = False

    def surface(self) -> TurnedSurface:
        """That of the shape, turned."""
        return TurnedSurface(self.shape.surface(), self.rotation, self.at, self.extent)


@dataclass(frozen=True, eq=False)
class TurnedSurface(Surface):
    """A surface turned by a rotation (3, 3) about its origin, which is then put at a point (3,) [m].

    ``whole``: its full size along x, y, z [m] as it then is.
    """

    surface: Surface
    rotation: Array
    at: Array
    whole: Extent

    @property
    def extent(self) -> Extent:
        """Full size along x, y, z [m]."""
        return self.whole

    def level(self, points: Array) -> Array:
        """That of the surface there [m], (...)."""
        return self.surface.level(self._seen(points))

    def normals(self, points: Array) -> Array:
        """Those of the surface there, turned, (..., 3)."""
        return rotated(self.surface.normals(self._seen(points)), self.rotation)

    def nearest(self, points: Array) -> Array:
        """Those of the surface, (..., 3) [m]."""
        return self._placed(self.surface.nearest(self._seen(points)))

    def sample(self, count: int, random: np.random.Generator) -> Array:
        """Those of the surface, (count, 3) [m]."""
        return self._placed(self.surface.sample(count, random))

    def rings(self, count: int) -> Array:
        """Those of the surface, from what was its lowest point to what was its highest."""
        return self._placed(self.surface.rings(count))

    def _seen(self, points: Array) -> Array:
        return rotated(points - self.at, self.rotation.T)

    def _placed(self, points: Array) -> Array:
        return rotated(points, self.rotation) + self.at
