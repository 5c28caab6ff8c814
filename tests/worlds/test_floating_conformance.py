"""The equations on floating contacts: what a correct implementation reaches from starts all over a surface."""

from __future__ import annotations

from itertools import combinations

import numpy as np
import pytest

from graspdsl.objects.surfaces.surface import Surface

from .floating_runs import (
    BOTTLE,
    CYLINDER,
    ELLIPSOID_A,
    ELLIPSOID_B,
    RADIUS,
    SPHERE,
    contacts,
    degrees_between,
    kept,
    outcome,
    pipelines,
    run,
    starts,
)

pytestmark = pytest.mark.slow

FORCE, GRASP = "π_fr|Γ Γ", "π_gx|Γ Γ"
VIRTUAL = "{γ1, <γ2, γ3>}"
EACH_ELLIPSOID = pytest.mark.parametrize("surface", [ELLIPSOID_A, ELLIPSOID_B], ids="AB")


@pytest.mark.parametrize("count", [2, 3, 4])
@pytest.mark.parametrize("formula", [FORCE, "φ_fr|τ_frx(Γ) σ_fr(Γ)"])
def test_force_residual_vanishes_on_a_sphere_and_never_rises(formula: str, count: int) -> None:
    (pipeline,) = pipelines(formula, contacts(count))
    end = run(pipeline, SPHERE, starts(SPHERE), 400)
    assert end.force_errors[-1].max() < 1e-6
    assert np.diff(end.force_errors, axis=0).max() < 1e-12


@pytest.mark.parametrize("formula", [FORCE, GRASP])
@pytest.mark.parametrize(("count", "angle"), [(2, 180.0), (3, 120.0)])
def test_contacts_on_a_sphere_end_evenly_apart(formula: str, count: int, angle: float) -> None:
    (pipeline,) = pipelines(formula, contacts(count))
    points = run(pipeline, SPHERE, starts(SPHERE), 400).points[:, :count]
    apart = [degrees_between(points[:, i], points[:, j]) for i, j in combinations(range(count), 2)]
    np.testing.assert_allclose(apart, angle, atol=0.01)


@EACH_ELLIPSOID
@pytest.mark.parametrize("formula", ["π_gx|Γ Γ", "π_g|Γ Γ"])
def test_three_contacts_on_an_ellipsoid_find_a_grasp(formula: str, surface: Surface) -> None:
    found = outcome(formula, 3, surface)
    assert found.converged.mean() >= 0.99
    assert np.median(found.ticks[found.converged]) < 40


@EACH_ELLIPSOID
@pytest.mark.parametrize("formula", ["π_cstar|Γ Γ", FORCE])
def test_one_after_the_other_or_force_alone_do_not_keep_a_grasp_on_an_ellipsoid(formula: str, surface: Surface) -> None:
    assert kept(formula, 3, surface).mean() <= 0.05


@EACH_ELLIPSOID
def test_grasps_on_an_ellipsoid_are_kept(surface: Surface) -> None:
    """Both residuals are low over the last twenty of a thousand steps."""
    assert kept(GRASP, 3, surface).mean() >= 0.99


def test_two_contacts_on_a_bottle_end_across_it() -> None:
    found = outcome(GRASP, 2, BOTTLE, of=1000)
    line = found.points[:, 0] - found.points[:, 1]
    lean = np.arcsin(np.abs(line[:, 2]) / np.linalg.norm(line, axis=-1))
    assert np.mean(found.converged & (lean < 0.05)) >= 0.99


def test_two_contacts_on_a_cylinder_find_a_grasp() -> None:
    """What is left are wedges of a cap and the side."""
    assert outcome(GRASP, 2, CYLINDER, of=3000).converged.mean() >= 0.98


@pytest.mark.parametrize("virtual", ["members", "common"])
def test_a_contact_ends_opposite_the_mean_of_a_virtual_contact(virtual: str) -> None:
    (pipeline,) = pipelines(GRASP, VIRTUAL, control=f"virtual: {virtual}")
    normals = -run(pipeline, SPHERE, starts(SPHERE), 200).points / RADIUS
    opposed = degrees_between(normals[:, 0], normals[:, 1] + normals[:, 2])
    np.testing.assert_allclose(opposed, 180.0, atol=0.5)


def test_members_of_a_virtual_contact_creep_together_with_the_square_of_time() -> None:
    """F = 0 asks that their normals agree; the nearer they are the slower they get: ε_fr ∝ t⁻²."""
    (pipeline,) = pipelines(GRASP, VIRTUAL)
    errors = run(pipeline, SPHERE, starts(SPHERE), 1601).force_errors
    ratios = errors[400] / errors[1600]
    assert np.diff(errors, axis=0).max() < 1e-12
    assert 12.0 < np.median(ratios) < 20.0


@pytest.mark.parametrize("share", [0.5, 1.0])
def test_members_kept_apart_leave_a_floor_of_the_force_residual(share: float) -> None:
    """ε_fr cannot fall below (1 − √(1 − (s/2R)²))² for members held at a distance s = share · R."""
    points, half = starts(SPHERE), share * RADIUS / 2
    height = np.sqrt(RADIUS**2 - half**2)
    points[:, 1], points[:, 2] = [half, 0.0, height], [-half, 0.0, height]
    (pipeline,) = pipelines("φ_fr|τ_frx(γ1) σ_fr(Γ)", VIRTUAL)
    end = run(pipeline, SPHERE, points, 400)
    np.testing.assert_array_equal(end.points[:, 1:], points[:, 1:])
    np.testing.assert_allclose(end.force_errors[-1], (1 - np.sqrt(1 - (share / 2) ** 2)) ** 2, rtol=0.1)
