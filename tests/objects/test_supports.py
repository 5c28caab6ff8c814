"""How far shapes reach, how large they are, which way they are long, and where their convex parts are."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from graspdsl.arrays import Array
from graspdsl.objects.box import Box
from graspdsl.objects.ellipsoid import Ellipsoid
from graspdsl.objects.shape import convex_parts, shaded
from graspdsl.objects.shapes import SHAPES as TABLE
from graspdsl.objects.shapes import Body
from graspdsl.objects.sphere import Sphere

from .thing import SHAPES, bounds, cells, inside

EACH_SHAPE = pytest.mark.parametrize("name", SHAPES)
DIRECTIONS = st.tuples(*[st.floats(-1.0, 1.0)] * 3).filter(lambda v: np.linalg.norm(v) > 0.1)
TESSELLATION = 5e-4  # m
DRAWN = 2.5e-3  # m: pictures show the edge of a cylinder rounded, those of a superquadric by few facets


def _unit(direction: tuple[float, float, float]) -> Array:
    return np.array(direction) / np.linalg.norm(direction)


def _reach(vertices: Array, direction: Array) -> float:
    return float((vertices @ direction).max())


def test_every_shape_that_a_spec_can_describe_is_here_under_its_own_name() -> None:
    assert {type(shape) for shape in SHAPES.values()} >= {*TABLE.values()}
    assert [kind.name for kind in TABLE.values()] == [*TABLE]


@EACH_SHAPE
@given(direction=DIRECTIONS)
@settings(deadline=None)  # the first facets of a shape take a while
def test_the_drawn_surface_reaches_as_far_as_the_shape(name: str, direction: tuple[float, float, float]) -> None:
    unit = _unit(direction)
    drawn = max(_reach(part.vertices, unit) for part in shaded(SHAPES[name]))
    exact = SHAPES[name].support(unit)
    assert exact - DRAWN < drawn < exact + 1e-9


@pytest.mark.slow
@EACH_SHAPE
@given(direction=DIRECTIONS)
@settings(deadline=None)  # the first facets of a shape take a while
def test_the_convex_parts_reach_as_far_as_the_shape(name: str, direction: tuple[float, float, float]) -> None:
    unit = _unit(direction)
    hulls = max(hull.support(unit) for hull in convex_parts(SHAPES[name]))
    assert SHAPES[name].support(unit) - TESSELLATION < hulls < SHAPES[name].support(unit) + 1e-5


@pytest.mark.slow
@EACH_SHAPE
def test_the_extent_is_that_of_what_is_inside(name: str) -> None:
    shape = SHAPES[name]
    low, high = bounds(shape)
    np.testing.assert_allclose(shape.extent, high - low, rtol=1e-12)
    assert low[2] == pytest.approx(-high[2])  # the origin is at half the height
    points, _ = cells(shape, 150)
    points = points[inside(shape, points)]
    np.testing.assert_allclose(np.ptp(points, axis=0), shape.extent, atol=0.08 * max(shape.extent))


@EACH_SHAPE
def test_normals_of_the_drawn_surface_point_out_of_its_triangles(name: str) -> None:
    for part in shaded(SHAPES[name]):
        np.testing.assert_allclose(np.linalg.norm(part.normals, axis=1), 1.0, atol=1e-9)
        a, b, c = (part.vertices[part.faces[:, i]] for i in range(3))
        across = np.cross(b - a, c - a)
        large = np.linalg.norm(across, axis=1) > 1e-9
        mean = part.normals[part.faces].mean(axis=1)
        assert ((across * mean).sum(axis=1)[large] > 0.0).all()


@pytest.mark.parametrize(
    ("shape", "axis"),
    [
        (Box(size=(0.09, 0.06, 0.18)), (0.0, 0.0, 1.0)),
        (Box(size=(0.18, 0.06, 0.09)), (1.0, 0.0, 0.0)),
        (Ellipsoid(size=(0.10, 0.14, 0.09)), (0.0, 1.0, 0.0)),
        (Ellipsoid(size=(0.104, 0.10, 0.09)), (0.0, 0.0, 1.0)),  # not clearly the longest
        (Sphere(diameter=0.1), (0.0, 0.0, 1.0)),
    ],
)
def test_the_major_axis_is_the_clearly_longest(
    shape: Box | Ellipsoid | Sphere, axis: tuple[float, float, float]
) -> None:
    assert Body("it", shape, 1.0).major_axis == axis


@EACH_SHAPE
def test_the_major_axis_is_a_unit_vector(name: str) -> None:
    assert np.linalg.norm(Body(name, SHAPES[name], 1.0).major_axis) == 1.0
