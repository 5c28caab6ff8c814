"""Objects in other poses: what turns with them, against sampling, against another library and against closed forms."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from graspdsl.objects.box import Box
from graspdsl.objects.cylinder import Cylinder
from graspdsl.objects.ellipsoid import Ellipsoid
from graspdsl.objects.shape import Shape
from graspdsl.objects.shapes import catalogue
from graspdsl.objects.sphere import Sphere
from graspdsl.objects.turned import Angles, Turned, posed, turned

from .thing import BRICK, EGG, cells, inside

RPY = (0.4, -1.1, 2.3)
TURN = Rotation.from_euler("xyz", RPY).as_matrix()  # about the fixed axes x, then y, then z
SHAPES: dict[str, Shape] = {
    "egg": EGG,
    "brick": BRICK,
    "can": Cylinder(diameter=0.08, height=0.2, edge=5e-4),
    "carton": Box(size=(0.05, 0.06, 0.13)),
    "bottle": catalogue()["bottle"].shape,
    "detergent": catalogue()["detergent-bottle"].shape,
}
EACH_SHAPE = pytest.mark.parametrize("shape", SHAPES.values(), ids=SHAPES)


def _turned(shape: Shape) -> Turned:
    found = turned(shape, RPY)
    assert isinstance(found, Turned)
    return found


@EACH_SHAPE
def test_its_mass_is_spread_as_points_in_it_are(shape: Shape) -> None:
    there = _turned(shape)
    points, cell = cells(there, 60)
    points = points[inside(shape, (points - there.at) @ TURN)]
    solid = there.solid
    assert solid.volume == pytest.approx(len(points) * cell, rel=0.02)
    np.testing.assert_allclose(solid.centre, points.mean(axis=0), atol=5e-3 * max(there.extent))
    away = points - points.mean(axis=0)
    np.testing.assert_allclose(solid.moments, cell * away.T @ away, atol=0.02 * np.trace(solid.moments))


@EACH_SHAPE
def test_it_reaches_as_far_as_its_corners_about_the_middle_of_its_box(shape: Shape) -> None:
    there = _turned(shape)
    corners = np.concatenate([part.vertices for part in shape.facets()]) @ TURN.T + there.at
    low, high = corners.min(axis=0), corners.max(axis=0)
    np.testing.assert_allclose(there.extent, high - low, atol=3e-3)
    np.testing.assert_allclose(low + high, 0.0, atol=4e-3)
    assert there.support(np.array([0.0, 0.0, 1.0])) == pytest.approx(there.extent[2] / 2, abs=1e-12)
    for direction in np.random.default_rng(3).normal(size=(40, 3)):
        unit = direction / np.linalg.norm(direction)
        assert there.support(unit) == pytest.approx((corners @ unit).max(), abs=3e-3)
    drawn = np.concatenate([part.vertices for part in there.facets()])
    np.testing.assert_allclose(drawn, corners, atol=1e-12)


@pytest.mark.parametrize("name", ["can", "carton", "bottle", "detergent"])
def test_its_convex_parts_reach_as_far(name: str) -> None:
    there = _turned(SHAPES[name])
    parts = there.hulls()
    for direction in np.random.default_rng(3).normal(size=(40, 3)):
        unit = direction / np.linalg.norm(direction)
        assert max(part.support(unit) for part in parts) == pytest.approx(there.support(unit), abs=1e-3)


@EACH_SHAPE
def test_what_is_in_it(shape: Shape) -> None:
    if shape.name == "compound":  # of which each part is asked
        return
    there = _turned(shape)
    points, _ = cells(there, 24)
    expected = inside(shape, (points - there.at) @ TURN)
    np.testing.assert_array_equal(there.inside()(points.reshape(24 * 24, 24, 3)).ravel(), expected)


@pytest.mark.parametrize("name", ["egg", "brick", "can", "bottle"])
def test_its_normals_are_the_gradient_of_its_level(name: str) -> None:
    surface = _turned(SHAPES[name]).surface()
    points = surface.sample(300, np.random.default_rng(5))
    assert np.abs(surface.level(points)).max() < 1e-12
    steps = 1e-6 * np.eye(3)
    slopes = np.stack([surface.level(points + step) - surface.level(points - step) for step in steps], axis=-1)
    slopes /= np.linalg.norm(slopes, axis=-1, keepdims=True)
    assert np.median(np.abs(surface.normals(points) - slopes)) < 1e-7
    out = points + 1e-3 * surface.normals(points)
    np.testing.assert_allclose(surface.nearest(out), points, atol=1e-9)


def test_its_curvature_at_the_end_of_an_axis() -> None:
    """Where an ellipsoid of semi-axes a, b, c ends along c, its curvatures are c/a² and c/b²."""
    a, b, c = (size / 2 for size in EGG.size)
    there = _turned(EGG)
    end = there.at + TURN @ (0.0, 0.0, c)
    found = there.surface().shape_operators(end)
    np.testing.assert_allclose(found, TURN @ np.diag([c / a**2, c / b**2, 0.0]) @ TURN.T, rtol=1e-6, atol=1e-6)


@pytest.mark.parametrize("shape", [*SHAPES.values(), Box(size=(0.2, 0.05, 0.06))])
def test_what_is_laid_down_has_its_major_axis_along_y(shape: Shape) -> None:
    there = posed(shape, "lay-down")
    np.testing.assert_allclose(there.major_axis, (0.0, 1.0, 0.0), atol=1e-15)
    along = shape.extent[int(np.argmax(shape.major_axis))]
    assert there.extent[1] == pytest.approx(along, rel=1e-12)


def test_what_is_upside_down_has_its_centre_as_much_above_the_middle_as_it_was_below() -> None:
    shape = SHAPES["detergent"]
    there = posed(shape, "upside-down")
    middle = (shape.support(np.array([0.0, 0.0, 1.0])) - shape.support(np.array([0.0, 0.0, -1.0]))) / 2
    assert there.solid.centre[2] == pytest.approx(middle - shape.solid.centre[2], abs=1e-12)
    np.testing.assert_allclose(there.major_axis, (0.0, 0.0, -1.0), atol=1e-15)


def test_angles_are_those_of_a_urdf() -> None:
    there = posed(Ellipsoid(size=(0.1, 0.12, 0.2)), Angles(rpy=(0.0, math.pi / 2, 0.0)))
    np.testing.assert_allclose(there.extent, (0.2, 0.12, 0.1), atol=1e-15)
    np.testing.assert_allclose(_turned(EGG).rotation, TURN, atol=1e-15)


def test_a_ball_stays_as_it_is() -> None:
    ball = Sphere(diameter=0.1)
    assert posed(ball, "lay-down") is ball


@pytest.mark.parametrize(
    ("shape", "axle"),
    [
        (Cylinder(diameter=0.1, height=0.2), (0.0, 0.0, 1.0)),
        (Ellipsoid(size=(0.1, 0.2, 0.1)), (0.0, 1.0, 0.0)),
        (Ellipsoid(size=(0.1, 0.1, 0.1)), None),
        (Ellipsoid(size=(0.1, 0.2, 0.3)), None),
        (Box(size=(0.1, 0.1, 0.3)), None),
    ],
)
def test_what_it_rolls_about(shape: Shape, axle: tuple[float, ...] | None) -> None:
    assert shape.axle == axle
    there = posed(shape, Angles(rpy=(math.pi / 2, 0.0, 0.0)))
    assert (there.axle is None) is (axle is None)
    assert there.lies_round is (axle == (0.0, 0.0, 1.0))
