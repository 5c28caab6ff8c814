"""What is known of each shape: radii, curvatures, flat sides, special cases that are other shapes."""

from __future__ import annotations

import numpy as np
import pytest

from graspdsl.arrays import Array
from graspdsl.objects.bottle import SmoothBottle
from graspdsl.objects.cylinder import RoundedCylinder
from graspdsl.objects.ellipsoid import SmoothEllipsoid
from graspdsl.objects.sphere import SmoothSphere
from graspdsl.objects.superquadric import SmoothSuperquadric
from graspdsl.objects.surfaces.surface import Surface

from .table import generator, tangent_steps

ROLL = RoundedCylinder(0.1, 0.2, 0.005)
BOTTLE = SmoothBottle(0.08, 0.25, 0.03, 0.15, 0.06, 0.02, 0.008)


def _clouds() -> list[Array]:
    """Points around a shape of about 0.1 m: near it and far from it."""
    return [generator().normal(size=(2000, 3)) * scale for scale in (0.03, 0.1, 3.0)]


def _curvature(surface: Surface, point: Array, step: Array) -> float:
    """How far the normal turns for each metre of a small step [rad/m]."""
    normals = surface.normals(surface.retract(np.array([point, point + step])))
    return float(np.linalg.norm(normals[1] - normals[0]) / np.linalg.norm(step))


def test_points_of_a_sphere_are_a_radius_from_its_centre() -> None:
    points = SmoothSphere(0.1).sample(1000, generator())
    np.testing.assert_allclose(np.linalg.norm(points, axis=-1), 0.05, rtol=1e-15)
    np.testing.assert_allclose(SmoothSphere(0.1).normals(points), points / 0.05, rtol=1e-13)


@pytest.mark.parametrize("diameter", [0.01, 0.1, 2.0])
def test_normals_of_a_sphere_turn_by_one_over_its_radius(diameter: float) -> None:
    sphere, random = SmoothSphere(diameter), generator()
    points = sphere.sample(1000, random)
    steps = tangent_steps(sphere, points, random)
    for length in np.array([1e-4, 1e-2, 0.3]) * diameter:
        turned = sphere.normals(sphere.retract(points + length * steps))
        angles = np.arctan2(
            np.linalg.norm(np.cross(sphere.normals(points), turned), axis=-1),
            np.sum(sphere.normals(points) * turned, axis=-1),
        )
        np.testing.assert_allclose(np.tan(angles), length / (diameter / 2), rtol=1e-10)


def test_curvatures_of_an_ellipsoid_at_its_vertices() -> None:
    axes = (0.05, 0.075, 0.11)
    for vertex in range(3):
        for along in {0, 1, 2} - {vertex}:
            point, step = axes[vertex] * np.eye(3)[vertex], 1e-7 * np.eye(3)[along]
            expected = axes[vertex] / axes[along] ** 2
            assert _curvature(SmoothEllipsoid(axes), point, step) == pytest.approx(expected, rel=1e-6)


def test_curvatures_of_a_cylinder() -> None:
    side, up, around = np.array([0.05, 0.0, 0.01]), np.array([0.0, 0.0, 1e-7]), np.array([0.0, 1e-7, 0.0])
    assert _curvature(ROLL, side, up) == 0.0
    assert _curvature(ROLL, side, around) == pytest.approx(1 / 0.05, rel=1e-6)
    edge = np.array([0.045, 0.0, 0.095]) + 0.005 * np.array([1.0, 0.0, 1.0]) / np.sqrt(2)
    assert _curvature(ROLL, edge, 1e-7 * np.array([1.0, 0.0, -1.0])) == pytest.approx(1 / 0.005, rel=1e-6)


def test_sides_and_ends_of_a_cylinder_are_where_they_should_be() -> None:
    points = np.array([[0.03, 0.04, 0.02], [0.02, -0.01, 0.1], [0.02, -0.01, -0.1]])
    np.testing.assert_array_equal(ROLL.retract(points), points)
    np.testing.assert_allclose(ROLL.normals(points), [[0.6, 0.8, 0.0], [0.0, 0.0, 1.0], [0.0, 0.0, -1.0]], atol=1e-15)
    np.testing.assert_allclose(ROLL.level(1.2 * points), [0.01, 0.02, 0.02], atol=1e-15)
    assert ROLL.level(np.zeros(3)) == pytest.approx(-0.05, abs=1e-15)


def test_level_of_a_capsule_is_the_distance_from_its_axis() -> None:
    capsule = RoundedCylinder(0.05, 0.2, 0.025)
    for points in _clouds():
        axis = np.zeros_like(points)
        axis[:, 2] = np.clip(points[:, 2], -0.075, 0.075)
        distances = np.linalg.norm(points - axis, axis=-1) - 0.025
        np.testing.assert_allclose(capsule.level(points), distances, atol=1e-13)


def test_level_of_a_cylinder_is_that_of_a_smaller_one_offset() -> None:
    """A rounded cylinder is what lies within ``edge`` of a sharp one: Minkowski sum with a ball."""
    for points in _clouds():
        beyond = np.stack([np.hypot(points[:, 0], points[:, 1]) - 0.045, np.abs(points[:, 2]) - 0.095], axis=-1)
        sharp = np.linalg.norm(np.maximum(beyond, 0.0), axis=-1) + np.minimum(beyond.max(axis=-1), 0.0)
        np.testing.assert_allclose(ROLL.level(points), sharp - 0.005, atol=1e-13)


@pytest.mark.parametrize("axes", [(0.05, 0.06, 0.08), (0.1, 0.1, 0.01), (0.01, 0.1, 0.02)])
def test_superquadric_of_exponent_two_is_an_ellipsoid(axes: tuple[float, float, float]) -> None:
    one, other = SmoothSuperquadric(axes, 2.0), SmoothEllipsoid(axes)
    for points in _clouds():
        outside = points[other.level(points) > 0.0]
        np.testing.assert_allclose(one.retract(outside), other.retract(outside), atol=1e-13)
        np.testing.assert_allclose(one.normals(points), other.normals(points), atol=1e-12)
        np.testing.assert_array_equal(np.sign(one.level(points)), np.sign(other.level(points)))


def test_ellipsoid_of_equal_axes_is_a_sphere() -> None:
    for points in _clouds():
        np.testing.assert_allclose(
            SmoothEllipsoid((0.05,) * 3).retract(points), SmoothSphere(0.1).retract(points), atol=1e-14
        )
        np.testing.assert_allclose(
            SmoothEllipsoid((0.05,) * 3).level(points), SmoothSphere(0.1).level(points), atol=1e-14
        )


@pytest.mark.parametrize("exponent", [2.5, 3.0, 8.0])
def test_points_of_a_superquadric_meet_its_equation(exponent: float) -> None:
    points = SmoothSuperquadric((0.05, 0.06, 0.08), exponent).sample(1000, generator())
    sums = np.sum(np.abs(points / [0.05, 0.06, 0.08]) ** exponent, axis=-1)
    np.testing.assert_allclose(sums, 1.0, atol=1e-13)


def test_a_bottle_has_a_body_a_shoulder_and_a_neck() -> None:
    heights = np.array([-0.125 + 0.07, -0.125 + 0.17, 0.125 - 0.03])
    outside = np.stack([[0.05, 0.04, 0.02], np.zeros(3), heights], axis=-1)
    feet = BOTTLE.retract(outside)
    np.testing.assert_allclose(feet[[0, 2]], [[0.04, 0.0, heights[0]], [0.015, 0.0, heights[2]]], atol=1e-15)
    assert 0.015 < feet[1, 0] < 0.04
    slope = np.array([0.04, 0.0, 0.025]) / np.hypot(0.04, 0.025)
    np.testing.assert_allclose(BOTTLE.normals(feet[1]), slope, atol=1e-14)


@pytest.mark.parametrize(
    ("build", "words"),
    [
        (lambda: SmoothSphere(0.0), "diameter"),
        (lambda: SmoothEllipsoid((0.1, -0.1, 0.1)), "semi axes"),
        (lambda: SmoothSuperquadric((0.1, 0.0, 0.1), 3.0), "semi axes"),
        (lambda: SmoothSuperquadric((0.1, 0.1, 0.1), 1.5), "exponent"),
        (lambda: SmoothSuperquadric((0.1, 0.1, 0.1), float("nan")), "exponent"),
        (lambda: RoundedCylinder(0.1, 0.2, 0.0), "positive"),
        (lambda: RoundedCylinder(0.1, 0.2, 0.06), "no room"),
        (lambda: RoundedCylinder(0.1, 0.02, 0.02), "no room"),
        (lambda: RoundedCylinder(-0.1, 0.2, 0.02), "keeps off"),
        (lambda: SmoothBottle(0.08, 0.25, 0.03, 0.15, 0.06, 0.5, 0.008), "no room"),
    ],
)
def test_impossible_shapes_are_refused(build: type[Surface], words: str) -> None:
    with pytest.raises(ValueError, match=words):
        build()
