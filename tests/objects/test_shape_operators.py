"""How normals turn as points slide over a surface: closed forms, and the contract of a shape operator."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from graspdsl.arrays import Array
from graspdsl.objects.cylinder import RoundedCylinder
from graspdsl.objects.ellipsoid import SmoothEllipsoid
from graspdsl.objects.sphere import SmoothSphere
from graspdsl.objects.superquadric import SmoothSuperquadric
from graspdsl.objects.surfaces.surface import Surface

AXES, EXPONENT = np.array([0.05, 0.06, 0.08]), 3.0
RADIUS, EDGE = 0.05, 0.005


def across(normals: Array) -> Array:
    """I − n nᵀ."""
    return np.asarray(np.eye(3) - normals[..., :, None] * normals[..., None, :])


def of_level_set(slope: Array, bend: Array) -> Array:
    """P H P / |g| of a level set with the gradient g and the diagonal Hessian H."""
    size = np.linalg.norm(slope, axis=-1)[..., None]
    tangent = across(slope / size)
    return np.asarray(tangent @ (bend[..., None] * tangent) / size[..., None])


def on_a_cylinder(points: Array) -> Array:
    """Flat ends, and 1/R around the wall; NaN on the rounded edges."""
    radial = points * [1.0, 1.0, 0.0] / RADIUS
    around = np.cross([0.0, 0.0, 1.0], radial)
    wall = around[..., :, None] * around[..., None, :] / RADIUS
    on_wall, on_end = (np.hypot(points[..., 0], points[..., 1]) > RADIUS - 1e-9), np.abs(points[..., 2]) > 0.1 - 1e-9
    return np.where(on_wall[..., None, None], wall, np.where(on_end[..., None, None], 0.0, np.nan))


CASES = {
    "sphere": (SmoothSphere(0.1), lambda x: across(x / RADIUS) / RADIUS),
    "ellipsoid": (SmoothEllipsoid(tuple(AXES)), lambda x: of_level_set(x / AXES**2, 0.0 * x + 1 / AXES**2)),
    "superquadric": (
        SmoothSuperquadric(tuple(AXES), EXPONENT),
        lambda x: of_level_set(
            np.sign(x) * np.abs(x) ** (EXPONENT - 1) / AXES**EXPONENT,
            (EXPONENT - 1) * np.abs(x) ** (EXPONENT - 2) / AXES**EXPONENT,
        ),
    ),
    "cylinder": (RoundedCylinder(0.1, 0.2, EDGE), on_a_cylinder),
}


@pytest.mark.parametrize(("surface", "closed"), CASES.values(), ids=CASES)
def test_it_is_the_closed_form(surface: Surface, closed: Callable[[Array], Array]) -> None:
    points = surface.sample(400, np.random.default_rng(83))
    found, wanted = surface.shape_operators(points), closed(points)
    known = np.isfinite(wanted).all(axis=(-2, -1))
    assert known.mean() > 0.9
    np.testing.assert_allclose(found[known], wanted[known], atol=1e-7 / RADIUS)
    np.testing.assert_allclose(found @ surface.normals(points)[..., None], 0.0, atol=1e-9)


def test_an_edge_has_two_curvatures() -> None:
    """On the rounding of a cylinder: 1 over its radius along the profile, and cos φ over the distance from the axis."""
    surface = RoundedCylinder(0.1, 0.2, EDGE)
    angle = 0.7
    point = np.array([RADIUS - EDGE + EDGE * np.cos(angle), 0.0, 0.1 - EDGE + EDGE * np.sin(angle)])
    curvatures = np.linalg.eigvalsh(surface.shape_operators(point))
    np.testing.assert_allclose(curvatures, [0.0, np.cos(angle) / point[0], 1.0 / EDGE], rtol=1e-6, atol=1e-6)
