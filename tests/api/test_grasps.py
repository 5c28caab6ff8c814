"""What is said of given contacts, against closed forms and against what controllers sense."""

from __future__ import annotations

import math

import numpy as np
import pytest
from compiler.observations import compiled, observation
from quality.grasps import antipodal, one_sided, random_contacts, ring

import graspdsl as g
from graspdsl.arrays import Array

RADIUS = 0.05


def tetrahedron() -> tuple[Array, Array]:
    """Four contacts on a ball, as far from one another as can be."""
    outward = np.array([[1.0, 1.0, 1.0], [1.0, -1.0, -1.0], [-1.0, 1.0, -1.0], [-1.0, -1.0, 1.0]]) / math.sqrt(3.0)
    return RADIUS * outward, -outward


# Residuals


@pytest.mark.parametrize("contacts", [antipodal(), ring(3), tetrahedron()])
def test_grasps_in_balance_leave_nothing_over(contacts: tuple[Array, Array]) -> None:
    found = g.residuals(*contacts)
    assert found.force_residual == pytest.approx(0.0, abs=1e-15)
    assert found.moment_residual == pytest.approx(0.0, abs=1e-15)


def test_two_normals_turned_from_the_line_between_them() -> None:
    """Each leaves sin θ of its newton across the line, both the same way: without a moment about the middle."""
    found = g.residuals(*antipodal(RADIUS, turned=0.3))
    assert found.force_residual == pytest.approx(2.0 * math.sin(0.3))
    assert found.force_squared == pytest.approx(4.0 * math.sin(0.3) ** 2)
    assert found.moment_residual == pytest.approx(0.0, abs=1e-15)
    about_one = g.residuals(*antipodal(RADIUS, turned=0.3), about=[-RADIUS, 0.0, 0.0])
    assert about_one.net_moment == pytest.approx([0.0, 0.0, 2.0 * RADIUS * math.sin(0.3)])
    assert about_one.moment_squared == pytest.approx((2.0 * RADIUS * math.sin(0.3)) ** 2)


@pytest.mark.parametrize("formula", ["{γ1, γ2, γ3}", "{γ1, <γ2, γ3>}"])
def test_they_are_what_controllers_sense_to_the_last_bit(formula: str) -> None:
    """γ1 is the thumb, the last of the hand's contacts; the members of a virtual contact weigh a half each."""
    pipeline = compiled(f"φ_mr|τ_mrx({formula}) σ_mr({formula})")
    weights = [0.5, 0.5, 1.0] if "<" in formula else None
    for seed in range(5):
        seen = observation(seed)
        tick, found = pipeline.evaluate(seen), g.residuals(seen.points, seen.normals, weights=weights)
        np.testing.assert_array_equal(found.net_force, tick.force_residual)
        np.testing.assert_array_equal(found.net_moment, tick.moment_residual)


def test_many_grasps_at_once() -> None:
    seen = observation(1, 4, 2)
    many = g.residuals(seen.points, seen.normals)
    assert many.force_residual.shape == many.moment_residual.shape == (4, 2)
    one = g.residuals(seen.points[3, 1], seen.normals[3, 1])
    assert many.moment_residual[3, 1] == pytest.approx(one.moment_residual, rel=1e-14)
    about = g.residuals(seen.points, seen.normals, about=seen.centre_of_mass)
    alone = g.residuals(seen.points[3, 1], seen.normals[3, 1], about=seen.centre_of_mass[3, 1])
    assert about.moment_residual[3, 1] == pytest.approx(alone.moment_residual, rel=1e-14)


# Closure


@pytest.mark.parametrize("friction", [0.2, 0.8])
@pytest.mark.parametrize("contacts", [ring(3), tetrahedron()])
def test_three_or_more_contacts_around_an_object_hold_it_with_friction(
    contacts: tuple[Array, Array], friction: float
) -> None:
    found = g.force_closure(*contacts, friction)
    assert found
    assert found.margin is not None
    assert found.margin > 0.0
    without = g.force_closure(*contacts, 0.0)
    assert not without
    assert without.reason == f"wrenches span {len(contacts[0]) - 1} of 6 dimensions"


def test_an_antipodal_pair_needs_soft_fingers() -> None:
    """Hard points cannot twist the object about the line between them."""
    assert g.force_closure(*antipodal(), 0.5, contact="hard").reason == "wrenches span 5 of 6 dimensions"
    assert g.force_closure(*antipodal(), 0.5)
    assert g.force_closure(*antipodal(), 0.5, torsion=0.002)
    assert g.force_closure(*one_sided(), 0.5).reason == "all forces in one half space"


def test_epsilon_of_an_antipodal_pair() -> None:
    """min(μ_t / r, μ' / √(2 + μ'²)), μ' the radius of the circle within the pyramid."""
    inner = 0.5 * math.cos(math.pi / 16)
    for torsion in (0.001, 0.04):
        found = g.ferrari_canny(*antipodal(RADIUS), 0.5, torsion=torsion)
        assert found.epsilon.value == pytest.approx(min(torsion / RADIUS, inner / math.sqrt(2.0 + inner**2)))


def test_epsilon_of_three_contacts_around_a_circle() -> None:
    """ε → μ/√5 as μ → 0. Force along the axis and moments across it come from friction along the axis alone, ±μ aᵢ
    with aᵢ = (1, qᵢ), qᵢ three unit vectors at 120°. A small part in the plane can even out what the contacts resist,
    for the normals sum to zero, but not lower its mean (μ/3) Σ |aᵢ·d|, which is least along a₁ × a₂:
    det(a₁, a₂, a₃) / (3 |a₁ × a₂|) = 1/√5."""
    friction = 1e-4
    found = g.ferrari_canny(*ring(3, RADIUS), friction)
    assert found.epsilon.value == pytest.approx(friction / math.sqrt(5.0), rel=1e-3)
    twice_as_long = g.ferrari_canny(*ring(3, RADIUS), friction, length=2.0 * RADIUS)
    assert twice_as_long.epsilon.value is not None
    assert twice_as_long.epsilon.value < 0.9 * friction / math.sqrt(5.0)


def test_moments_are_taken_about_the_point_that_is_given() -> None:
    points, normals = random_contacts(3, 4)
    middle = points.mean(axis=0)
    moved = g.ferrari_canny(points + 1.0, normals, 0.5, about=middle + 1.0)
    assert moved.epsilon.value == pytest.approx(g.ferrari_canny(points, normals, 0.5).epsilon.value)
    beside = g.ferrari_canny(points, normals, 0.5, about=[0.03, 0.0, 0.0])
    assert beside.epsilon.value != pytest.approx(moved.epsilon.value, rel=1e-3)


# What cannot be contacts


@pytest.mark.parametrize(
    ("points", "normals", "said"),
    [
        ([0.0, 0.0, 0.0], [0.0, 0.0, 1.0], r"points: expected the shape \(\.\.\., k, 3\), a row a contact, found \(3,"),
        (np.zeros((3, 2)), np.zeros((3, 2)), r"found \(3, 2\)"),
        (np.zeros((3, 3)), np.eye(3)[:2], r"normals: expected the shape \(3, 3\), found \(2, 3\)"),
        ([[0.0, 0.0, math.nan]], [[0.0, 0.0, 1.0]], "points: expected finite numbers, found nan"),
        ([[0.0, 0.0, 0.0]], [[0.0, 0.0, math.inf]], "normals: expected finite numbers, found inf"),
        ([[0.0, 0.0, 0.0]], [[0.0, 0.0, 2.0]], "normals: expected unit vectors into the object, found one of length 2"),
        ([[0.0, 0.0, 0.0]], [[0.0, 0.0, 1.0 + 1e-5]], "length 1.00001"),
        ([[0.0, 0.0, 1j]], [[0.0, 0.0, 1.0]], "points: expected numbers, found"),
    ],
)
def test_what_cannot_be_contacts_is_refused(points: object, normals: object, said: str) -> None:
    for judge in (g.residuals, lambda *contacts: g.force_closure(*contacts, 0.4)):
        with pytest.raises(ValueError, match=said):
            judge(points, normals)


def test_other_numbers_are_refused_too() -> None:
    contacts = ring(3)
    with pytest.raises(ValueError, match=r"about: expected the shape \(3,\), found \(2,\)"):
        g.residuals(*contacts, about=[0.0, 0.0])
    with pytest.raises(ValueError, match="about: expected finite numbers"):
        g.residuals(*contacts, about=[0.0, 0.0, math.nan])
    with pytest.raises(ValueError, match=r"weights: expected the shape \(3,\), found \(2,\)"):
        g.residuals(*contacts, weights=[1.0, 1.0])
    with pytest.raises(ValueError, match="no centroid"):
        g.residuals(*contacts, weights=[1.0, -1.0, 0.0])
    with pytest.raises(ValueError, match="a friction coefficient is not negative"):
        g.force_closure(*contacts, -0.1)
    with pytest.raises(ValueError, match="a torsional coefficient is not negative"):
        g.ferrari_canny(*contacts, 0.4, torsion=-0.1)
    with pytest.raises(ValueError, match="even number of edges"):
        g.ferrari_canny(*contacts, 0.4, edges=5)
