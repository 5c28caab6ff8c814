"""Shapes for the tests, and a second opinion on what is inside of them."""

from __future__ import annotations

from functools import singledispatch

import numpy as np

from graspdsl.arrays import Array, Flags
from graspdsl.objects.bottle import Bottle
from graspdsl.objects.box import Box
from graspdsl.objects.compound import Compound, Loft
from graspdsl.objects.cylinder import Cylinder
from graspdsl.objects.ellipsoid import Ellipsoid
from graspdsl.objects.shape import Shape
from graspdsl.objects.shapes import Body, catalogue
from graspdsl.objects.sphere import Sphere
from graspdsl.objects.superquadric import Superquadric

EGG = Ellipsoid(size=(0.10, 0.12, 0.16))
PILLOW = Superquadric(size=(0.12, 0.09, 0.10), exponent=3.0)
BRICK = Superquadric(size=(0.09, 0.06, 0.14), exponent=8.0)
SHAPES: dict[str, Shape] = {
    **{name: body.shape for name, body in catalogue().items()},
    "egg": EGG,
    "pillow": PILLOW,
    "brick": BRICK,
}
BODIES = {name: Body(name, shape, 0.5) for name, shape in SHAPES.items()} | dict(catalogue())


@singledispatch
def inside(shape: object, points: Array) -> Flags:
    """Which points (n, 3) are in the shape, each by its own inequality."""
    raise TypeError(f"{len(points)} points of {type(shape)}")


@inside.register
def _(shape: Sphere, points: Array) -> Flags:
    return np.asarray((points**2).sum(axis=1) < shape.diameter**2 / 4)


@inside.register
def _(shape: Box, points: Array) -> Flags:
    return np.asarray((np.abs(points) < np.array(shape.size) / 2).all(axis=1))


@inside.register
def _(shape: Cylinder, points: Array) -> Flags:
    return np.asarray((np.hypot(*points.T[:2]) < shape.diameter / 2) & (np.abs(points[:, 2]) < shape.height / 2))


@inside.register
def _(shape: Ellipsoid, points: Array) -> Flags:
    return np.asarray(((2 * points / np.array(shape.size)) ** 2).sum(axis=1) < 1.0)


@inside.register
def _(shape: Superquadric, points: Array) -> Flags:
    return np.asarray((np.abs(2 * points / np.array(shape.size)) ** shape.exponent).sum(axis=1) < 1.0)


@inside.register
def _(shape: Bottle, points: Array) -> Flags:
    return np.asarray(shape.surface().level(points) < 0.0)


@inside.register
def _(shape: Loft, points: Array) -> Flags:
    outline = shape.profile.outline(200)
    within = (points[:, 2] > outline[0, 1]) & (points[:, 2] < outline[-1, 1])
    half = np.interp(points[:, 2], outline[:, 1], outline[:, 0])
    x, y = np.abs(points[:, 0]), np.abs(points[:, 1]) / shape.width
    return np.asarray(within & (x**shape.exponent + y**shape.exponent < half**shape.exponent))


@inside.register
def _(shape: Compound, points: Array) -> Flags:
    return np.asarray(sum(parts_inside(shape, points)) > 0)


def parts_inside(shape: Compound, points: Array) -> list[Flags]:
    """Which points (n, 3) are in each part of a compound."""
    return [inside(p.part, (points - np.array(p.at)) @ p.rotation) for p in shape.parts]


def bounds(shape: Shape) -> tuple[Array, Array]:
    """The lowest and the highest coordinates (3,) of a shape."""
    return -np.array([shape.support(-axis) for axis in np.eye(3)]), np.array([shape.support(a) for a in np.eye(3)])


def cells(shape: Shape, count: int) -> tuple[Array, float]:
    """The centres (n, 3) of even cells that fill the box about a shape, and the volume of each."""
    low, high = bounds(shape)
    lines = [a + (b - a) * (np.arange(count) + 0.5) / count for a, b in zip(low, high, strict=True)]
    return np.stack(np.meshgrid(*lines, indexing="ij"), axis=-1).reshape(-1, 3), float(np.prod((high - low) / count))
