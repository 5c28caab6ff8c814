"""What every surface has to do, over a table of all kinds."""

from __future__ import annotations

import numpy as np
import pytest

from graspdsl.arrays import Array
from graspdsl.objects.superquadric import SmoothSuperquadric
from graspdsl.objects.surfaces.surface import Surface

from .table import (
    EACH_CONVEX_SURFACE,
    EACH_EXACT_SURFACE,
    EACH_SURFACE,
    generator,
    special_points,
    tangent_steps,
)

ON = 1e-12  # of the size


def _near(surface: Surface, share: float) -> Array:
    """Points off the surface by up to a share of its size, to either side."""
    random = generator()
    return surface.sample(2000, random) + share * surface.size * random.uniform(-1, 1, (2000, 3))


def _gradients(surface: Surface, points: Array) -> Array:
    """Central differences of the level, (n, 3)."""
    steps = 1e-6 * surface.size * np.eye(3)
    slopes = [surface.level(points + step) - surface.level(points - step) for step in steps]
    return np.stack(slopes, axis=-1) / (2e-6 * surface.size)


@EACH_SURFACE
def test_normals_are_the_gradients_of_the_level(surface: Surface) -> None:
    points = surface.sample(2000, generator())
    gradients = _gradients(surface, points)
    gradients /= np.linalg.norm(gradients, axis=-1, keepdims=True)
    np.testing.assert_allclose(surface.normals(points), gradients, atol=2e-4)
    # Closer still where the curvature does not jump between the two sides of the difference.
    assert np.median(np.abs(surface.normals(points) - gradients)) < 1e-8


@EACH_SURFACE
def test_normals_are_unit_vectors(surface: Surface) -> None:
    points = np.concatenate([special_points(surface), _near(surface, 0.3)])
    np.testing.assert_allclose(np.linalg.norm(surface.normals(points), axis=-1), 1.0, atol=1e-14)


@EACH_SURFACE
def test_level_tells_inside_from_outside(surface: Surface) -> None:
    points = surface.sample(2000, generator())
    offset = 1e-3 * surface.size * surface.normals(points)
    assert np.all(surface.level(points + offset) > 0.0)
    assert np.all(surface.level(points - offset) < 0.0)
    assert surface.level(np.zeros(3)) < 0.0
    np.testing.assert_allclose(surface.level(points), 0.0, atol=ON * surface.size)


@EACH_SURFACE
def test_level_is_never_less_than_the_distance(surface: Surface) -> None:
    points = _near(surface, 0.3)
    outside = surface.level(points) > 0.0
    gaps = np.linalg.norm(surface.retract(points) - points, axis=-1)
    assert np.all(surface.level(points)[outside] >= gaps[outside] - ON * surface.size)


@pytest.mark.parametrize("share", [1e-9, 1e-6, 1e-3, 0.03, 0.3, 3.0, 1e3])
@EACH_SURFACE
def test_retraction_ends_on_the_surface(surface: Surface, share: float) -> None:
    feet = surface.retract(_near(surface, share))
    assert np.abs(surface.level(feet)).max() < ON * surface.size


@EACH_SURFACE
def test_retraction_leaves_points_of_the_surface_alone(surface: Surface) -> None:
    points = np.concatenate([surface.sample(2000, generator()), surface.retract(_near(surface, 0.3))])
    np.testing.assert_array_equal(surface.retract(points), points)


@EACH_SURFACE
def test_retraction_undoes_a_step_along_the_normal(surface: Surface) -> None:
    points = surface.sample(2000, generator())
    normals = surface.normals(points)
    for outward in (0.3 if surface.level(np.zeros(3)) == -surface.size / 2 else 0.01, 1e-3):
        back = surface.retract(points + outward * surface.size * normals)
        np.testing.assert_allclose(back, points, atol=1e-11 * surface.size)


@EACH_EXACT_SURFACE
def test_retraction_undoes_a_small_step_inwards(surface: Surface) -> None:
    points = surface.sample(2000, generator())
    inwards = points - 4e-4 * surface.size * surface.normals(points)
    np.testing.assert_allclose(surface.retract(inwards), points, atol=1e-10 * surface.size)


@EACH_SURFACE
def test_error_of_a_step_inwards_is_of_second_order(surface: Surface) -> None:
    points = surface.sample(2000, generator())
    normals = surface.normals(points)
    errors = [
        np.linalg.norm(surface.retract(points - depth * surface.size * normals) - points, axis=-1).max()
        for depth in (1e-4, 2.5e-5)
    ]
    assert errors[1] <= errors[0] / 16 * 1.2 + ON * surface.size


@EACH_SURFACE
def test_retraction_of_a_tangent_step_adds_to_second_order_along_the_normal(surface: Surface) -> None:
    random = generator()
    points = surface.sample(5000, random)
    normals, steps = surface.normals(points), tangent_steps(surface, points, random)

    def added(share: float) -> tuple[float, float]:
        moved = points + share * surface.size * steps
        shift = surface.retract(moved) - moved
        along = np.sum(shift * normals, axis=-1)
        across = np.linalg.norm(shift - along[:, None] * normals, axis=-1)
        return float(np.abs(along).max()), float(across.max())

    (along, across), (along_half, across_half) = added(4e-4), added(2e-4)
    assert along_half == pytest.approx(along / 4, rel=0.1)
    assert across_half == pytest.approx(across / 8, rel=0.2)


@pytest.mark.parametrize("share", [1e-3, 0.1, 0.3])
@EACH_CONVEX_SURFACE
def test_a_point_outside_goes_to_the_nearest_point(surface: Surface, share: float) -> None:
    """On a convex surface x is nearest to y if y − x is along the outward normal at x, and only then."""
    random = generator()
    points = surface.sample(5000, random)
    moved = points + share * surface.size * tangent_steps(surface, points, random)
    feet = surface.retract(moved)
    gaps, normals = moved - feet, surface.normals(feet)
    distances = np.sum(gaps * normals, axis=-1)
    assert np.all(distances > -ON * surface.size)
    np.testing.assert_allclose(gaps, distances[:, None] * normals, atol=1e-10 * surface.size)


@EACH_EXACT_SURFACE
def test_no_sampled_point_is_nearer_than_the_nearest(surface: Surface) -> None:
    others = surface.sample(5000, generator())
    for point in _near(surface, 0.5)[:200]:
        found = np.linalg.norm(surface.retract(point) - point)
        assert found <= np.linalg.norm(others - point, axis=-1).min() + ON * surface.size


@EACH_SURFACE
def test_special_points_give_numbers(surface: Surface) -> None:
    points = special_points(surface)
    feet = surface.retract(points)
    for result in (surface.level(points), surface.normals(points), feet, surface.normals(feet)):
        assert np.all(np.isfinite(result))
    assert np.abs(surface.level(feet)).max() < ON * surface.size


@pytest.mark.slow
@EACH_SURFACE
def test_a_batch_gives_what_its_points_give_alone(surface: Surface) -> None:
    points = np.concatenate([_near(surface, 0.1)[:50], special_points(surface)[:150]])
    for function in (surface.level, surface.normals, surface.retract):
        alone = np.array([function(point) for point in points])
        shaped = function(points.reshape(4, 25, 2, 3))
        assert shaped.shape == (4, 25, 2, *alone.shape[1:])
        for batch in (function(points), shaped.reshape(alone.shape)):
            if isinstance(surface, SmoothSuperquadric):
                np.testing.assert_allclose(batch, alone, rtol=1e-14, atol=1e-14)
            else:
                np.testing.assert_array_equal(batch, alone)
        assert function(np.empty((0, 3))).shape == (0, *alone.shape[1:])


@EACH_SURFACE
def test_arguments_are_left_alone(surface: Surface) -> None:
    points = _near(surface, 0.1)
    before = points.copy()
    surface.level(points), surface.normals(points), surface.retract(points)
    np.testing.assert_array_equal(points, before)


@EACH_SURFACE
def test_mirrored_points_have_mirrored_results(surface: Surface) -> None:
    points = _near(surface, 0.2)
    for mirror in np.array([[-1.0, 1.0, 1.0], [1.0, -1.0, 1.0], [-1.0, -1.0, 1.0]]):
        np.testing.assert_allclose(surface.level(mirror * points), surface.level(points), atol=1e-15)
        np.testing.assert_allclose(surface.normals(mirror * points), mirror * surface.normals(points), atol=1e-12)
        np.testing.assert_allclose(surface.retract(mirror * points), mirror * surface.retract(points), atol=1e-14)


@EACH_SURFACE
def test_extent_is_that_of_the_points(surface: Surface) -> None:
    points, (x, y, _) = surface.sample(2000, generator()), surface.extent
    np.testing.assert_allclose(np.ptp(surface.mesh(24).vertices, axis=0), surface.extent, rtol=1e-12)
    assert np.all(np.ptp(points, axis=0) <= np.array(surface.extent) * (1.0 + 1e-12))
    assert np.all(np.abs(points[:, :2]) <= np.array([x, y]) / 2 * (1.0 + 1e-12))
    assert surface.size == max(surface.extent)
