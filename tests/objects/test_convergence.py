"""Newton's method on ellipsoids and superquadrics arrives, from anywhere and without ever passing the root."""

from __future__ import annotations

import numpy as np
import pytest

from graspdsl.arrays import Array
from graspdsl.objects import ellipsoid, superquadric
from graspdsl.objects.ellipsoid import SmoothEllipsoid
from graspdsl.objects.superquadric import SmoothSuperquadric
from graspdsl.objects.surfaces.surface import Surface

from .table import generator, tangent_steps

AXES = [(1.0, 1.0, 1.0), (1.0, 1.2, 1.6), (1.0, 1.0, 2.0), (0.01, 1.0, 1.0), (0.01, 0.1, 1.0), (1.0, 1.0, 0.01)]
EACH_AXES = pytest.mark.parametrize("axes", AXES, ids=str)
EXPONENTS = [2.0, 2.01, 2.5, 3.0, 4.0, 8.0, 10.0]
EACH_EXPONENT = pytest.mark.parametrize("exponent", EXPONENTS)


def _anywhere(axes: tuple[float, float, float]) -> Array:
    """Points with coordinates over many orders of magnitude, some of them zero, and points close to the surface."""
    random = generator()
    spread = 10.0 ** random.uniform(-12, 4, (20_000, 3)) * random.choice([-1.0, 1.0, 1.0, 0.0], (20_000, 3))
    return np.concatenate([spread, spread * np.array(axes), np.array(axes) * random.normal(size=(20_000, 3))])


def _assert_nearest(surface: Surface, points: Array, feet: Array) -> None:
    """The feet are on the surface, and the way from them to the points is along the normals."""
    assert np.abs(surface.level(feet)).max() < 1e-12 * surface.size
    gaps, normals = points - feet, surface.normals(feet)
    along = np.sum(gaps * normals, axis=-1, keepdims=True)
    scale = np.linalg.norm(points, axis=-1, keepdims=True) + surface.size
    assert np.max(np.abs(gaps - along * normals) / scale) < 1e-9


@EACH_AXES
def test_ellipsoid_from_anywhere(axes: tuple[float, float, float]) -> None:
    surface, points = SmoothEllipsoid(axes), _anywhere(axes)
    feet = surface.nearest(points)
    _assert_nearest(surface, points, feet)
    inside = surface.level(points) < 0.0
    # Inside, too, no other point is nearer: the ball about the point through its foot has to fit.
    reach = np.linalg.norm(points - feet, axis=-1)[inside]
    others = surface.sample(300, generator())
    gaps = np.linalg.norm(points[inside][:2000, None] - others, axis=-1).min(axis=1)
    assert np.all(reach[:2000] <= gaps + 1e-12)


@pytest.mark.slow
@EACH_EXPONENT
@EACH_AXES
def test_superquadric_from_anywhere(axes: tuple[float, float, float], exponent: float) -> None:
    surface, points = SmoothSuperquadric(axes, exponent), _anywhere(axes)
    feet = surface.nearest(points)
    outside = surface.level(points) > 0.0
    _assert_nearest(surface, points[outside], feet[outside])
    assert np.abs(surface.level(feet)).max() < 1e-12 * surface.size


@EACH_EXPONENT
@EACH_AXES
def test_reciprocal_gauge_is_concave_and_growing(axes: tuple[float, float, float], exponent: float) -> None:
    """The property that the climb to the root rests on: 1/|u(λ)|_p, with u(λ) by bisection."""
    random = generator()
    v = 10.0 ** random.uniform(-2, 1, (200, 3))
    multipliers = 10.0 ** np.linspace(-4, 4, 60)
    slopes = multipliers[:, None, None] / np.array(axes) ** 2
    low, high = np.zeros((60, 200, 3)), np.broadcast_to(v, (60, 200, 3)).copy()
    for _ in range(80):
        middle = (low + high) / 2
        above = middle + slopes * middle ** (exponent - 1.0) > v
        low, high = np.where(above, low, middle), np.where(above, middle, high)
    values = np.sum(high**exponent, axis=-1) ** (-1.0 / exponent)
    chords = np.diff(values, axis=0) / np.diff(multipliers)[:, None]
    assert np.all(chords > -1e-9 * values[1:])
    assert np.all(np.diff(chords, axis=0) <= 1e-9 * chords[:-1] + 1e-12 * values[1:-1] / multipliers[1:-1, None])


@pytest.mark.parametrize(("module", "surface"), [(ellipsoid, SmoothEllipsoid((0.05, 0.075, 0.11)))])
def test_few_passes_are_enough_for_an_ellipsoid(
    module: object, surface: Surface, monkeypatch: pytest.MonkeyPatch
) -> None:
    _assert_few_passes(module, surface, 9, monkeypatch)


@EACH_EXPONENT
def test_few_passes_are_enough_for_a_superquadric(exponent: float, monkeypatch: pytest.MonkeyPatch) -> None:
    _assert_few_passes(superquadric, SmoothSuperquadric((0.05, 0.06, 0.08), exponent), 12, monkeypatch)


def _assert_few_passes(module: object, surface: Surface, passes: int, monkeypatch: pytest.MonkeyPatch) -> None:
    """After steps of 0.3 of the size the same points come out of a loop cut short."""
    random = generator()
    points = surface.sample(20_000, random)
    moved = points + 0.3 * surface.size * tangent_steps(surface, points, random)
    feet = surface.nearest(moved)
    monkeypatch.setattr(module, "MOST_PASSES", passes)
    np.testing.assert_array_equal(surface.nearest(moved), feet)
