"""Epsilon and volume against closed forms and against the least of the support function over directions."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import minimize
from scipy.spatial import ConvexHull

from graspdsl.arrays import Array
from graspdsl.quality.contact_models import ContactModel, FrictionlessPoint, HardPoint, SoftFinger
from graspdsl.quality.ferrari_canny import ferrari_canny
from graspdsl.quality.wrench_space import WrenchSpace, wrench_space
from quality.grasps import Contacts, antipodal, coupled, one_sided, random_contacts, raw, ring, rotations


def _value(space: WrenchSpace) -> float:
    value = ferrari_canny(space).epsilon.value
    assert value is not None
    return value


# Closed forms


@pytest.mark.parametrize("scale", [1.0, 0.01])
def test_a_cross_polytope(scale: float) -> None:
    found = ferrari_canny(raw(scale * np.vstack([np.eye(6), -np.eye(6)])))
    assert found.epsilon.value == pytest.approx(scale / math.sqrt(6.0))
    assert found.volume.value == pytest.approx((2.0 * scale) ** 6 / math.factorial(6))


def test_a_flat_cross_polytope_loses_no_digits() -> None:
    half_axes = np.array([1.0, 1.0, 1.0, 1.0, 1.0, 1e-6])
    found = ferrari_canny(raw(np.vstack([np.diag(half_axes), -np.diag(half_axes)])))
    assert found.epsilon.value == pytest.approx(1.0 / math.sqrt((half_axes**-2.0).sum()), rel=1e-9)
    assert found.volume.value == pytest.approx(2.0**6 * 1e-6 / math.factorial(6), rel=1e-9)


def test_a_cube() -> None:
    corners = np.stack(np.meshgrid(*[[-1.0, 1.0]] * 6), axis=-1).reshape(-1, 6)
    found = ferrari_canny(raw(corners))
    assert found.epsilon.value == pytest.approx(1.0)
    assert found.volume.value == pytest.approx(2.0**6)


@pytest.mark.parametrize("friction", [0.2, 0.5, 1.2])
@pytest.mark.parametrize("torsion", [0.001, 0.05])
@pytest.mark.parametrize("edges", [8, 16])
def test_two_antipodal_soft_contacts(friction: float, torsion: float, edges: int) -> None:
    """ε = min(μ_t / r, μ' / √(2 + μ'²)), μ' = μ cos(π/edges) the radius of the circle inside the pyramid.

    About the line between them only torsion resists. With moments over r, the tangential wrenches of the two contacts
    fill circles of radius √2 μ' in planes at right angles, at ±1 along the line; the nearest facet cuts one circle.
    """
    radius = 0.05
    inner = friction * math.cos(math.pi / edges)
    expected = min(torsion / radius, inner / math.sqrt(2.0 + inner**2))
    assert _value(wrench_space(*antipodal(radius), SoftFinger(friction, torsion, edges))) == pytest.approx(expected)


# The least of the support function


def _least_support(wrenches: Array, seed: int) -> float:
    """min over unit d of max_i d·wᵢ: 1e5 directions, the best of them refined. Plain sampling comes out too large."""
    random = np.random.default_rng(seed)
    directions = random.normal(size=(100_000, 6))
    directions /= np.linalg.norm(directions, axis=1)[:, None]
    supports = (directions @ wrenches.T).max(axis=1)
    least = math.inf
    for direction in directions[np.argsort(supports)[:60]]:
        start = np.append(direction, (wrenches @ direction).max())
        answer = minimize(
            lambda x: x[6],
            start,
            jac=lambda _: np.append(np.zeros(6), 1.0),
            constraints=[
                {
                    "type": "ineq",
                    "fun": lambda x: x[6] - wrenches @ x[:6],
                    "jac": lambda _: np.column_stack([-wrenches, np.ones(len(wrenches))]),
                },
                {"type": "eq", "fun": lambda x: x[:6] @ x[:6] - 1.0, "jac": lambda x: np.append(2.0 * x[:6], 0.0)},
            ],
            method="SLSQP",
        )
        found = answer.x[:6] / np.linalg.norm(answer.x[:6])
        least = min(least, float((wrenches @ found).max()))
    return least


@pytest.mark.slow
@pytest.mark.parametrize(
    ("contacts", "model"),
    [
        (ring(), HardPoint(0.5, 8)),
        (ring(), HardPoint(0.5)),
        (ring(4), SoftFinger(0.4, 0.01, 8)),
        (antipodal(turned=0.1), SoftFinger(0.5, 0.01, 8)),
        (random_contacts(4, 4), HardPoint(0.6, 8)),
        (random_contacts(9, 5), HardPoint(0.8, 8)),
    ],
)
def test_epsilon_is_the_least_support(contacts: Contacts, model: ContactModel) -> None:
    space = wrench_space(*contacts, model)
    epsilon = _value(space)
    assert epsilon > 0.0
    assert _least_support(space.wrenches, 3) == pytest.approx(epsilon, abs=1e-3)


# What pyramids leave out


def _least_reach(space: WrenchSpace, seed: int) -> float:
    """min over unit d of h(d) with round cones, as above: without a hull."""
    random = np.random.default_rng(seed)
    directions = random.normal(size=(100_000, 6))
    directions /= np.linalg.norm(directions, axis=1)[:, None]
    reaches = space.support(directions)
    least = math.inf
    for direction in directions[np.argsort(reaches)[:30]]:
        answer = minimize(
            lambda x: x[6],
            np.append(direction, space.support(direction[None])[0]),
            constraints=[
                {"type": "ineq", "fun": lambda x: x[6] - space.model.support(space.basis @ x[:6])},
                {"type": "eq", "fun": lambda x: x[:6] @ x[:6] - 1.0},
            ],
            method="SLSQP",
        )
        found = answer.x[:6] / np.linalg.norm(answer.x[:6])
        least = min(least, float(space.support(found[None])[0]))
    return least


@pytest.mark.slow
@pytest.mark.parametrize(
    ("contacts", "model"),
    [
        (ring(), HardPoint(0.5, 8)),
        (random_contacts(4, 4), HardPoint(0.6, 8)),
        (antipodal(turned=0.2), SoftFinger(0.5, 0.03, 8)),
    ],
)
def test_the_epsilon_of_round_cones_is_between_that_of_pyramids_and_the_bound(
    contacts: Contacts, model: HardPoint | SoftFinger
) -> None:
    """Pyramids of n edges hold cones of μ cos(π/n), and no more than is said is left out."""
    space = wrench_space(*contacts, model)
    found, whole = ferrari_canny(space), _least_reach(space, 3)
    assert found.epsilon.value is not None
    assert found.shortfall.value is not None
    assert found.epsilon.value <= whole <= found.epsilon.value / (1.0 - found.shortfall.value) * (1.0 + 1e-6)
    assert 0.0 < found.shortfall.value < 0.35
    held = replace(model, friction=model.friction * math.cos(math.pi / model.edges))
    assert _least_reach(replace(space, model=held), 3) <= found.epsilon.value * (1.0 + 1e-6)


@pytest.mark.parametrize("torsion", [0.001, 0.05])
@pytest.mark.parametrize("edges", [4, 8, 16])
def test_the_bound_of_two_antipodal_soft_contacts(torsion: float, edges: int) -> None:
    """Where torsion decides nothing is left out; where friction does, what a circle has beyond its polygon."""
    found = ferrari_canny(wrench_space(*antipodal(0.05), SoftFinger(0.5, torsion, edges), length=0.05))
    whole = min(torsion / 0.05, 0.5 / math.sqrt(2.25))
    assert found.epsilon.value is not None
    assert found.shortfall.value is not None
    assert found.epsilon.value <= whole * (1.0 + 1e-9)
    assert found.epsilon.value / (1.0 - found.shortfall.value) >= whole * (1.0 - 1e-9)
    assert (found.shortfall.value < 1e-9) == (torsion == 0.001)


@pytest.mark.parametrize("scale", [0.01, 7.0])
@pytest.mark.parametrize("seed", [4, 9])
def test_object_torque_scale_and_torsion_in_another_unit_change_nothing(seed: int, scale: float) -> None:
    points, normals = random_contacts(seed, 4)
    one, other = (
        ferrari_canny(
            wrench_space(by * points, normals, SoftFinger(0.5, by * 0.002, 4), reference=np.zeros(3), length=by * 0.04)
        )
        for by in (1.0, scale)
    )
    for name in ("epsilon", "shortfall", "volume"):
        assert getattr(one, name).value == pytest.approx(getattr(other, name).value, rel=1e-6)


@pytest.mark.parametrize("seed", [15, 16, 19, 21])
def test_a_hull_that_rounding_has_confused_is_not_flat(seed: int) -> None:
    """Many edges of two soft fingers lie on one facet, but for rounding."""
    eight, sixteen = (wrench_space(*random_contacts(seed, 2), SoftFinger(0.4, 1e-4, edges)) for edges in (8, 16))
    less, more = ferrari_canny(eight).volume, ferrari_canny(sixteen).volume
    assert less.value is not None
    assert more.value is not None
    assert 0.0 < less.value < more.value < 1.2 * less.value  # with all of the cones 1.23 times as large, (π / 2√2)²
    assert (less.reason, more.reason) == ("", "")


# No closure


@pytest.mark.parametrize(
    ("contacts", "model", "reason"),
    [
        (antipodal(), HardPoint(0.5), "wrenches span 5 of 6 dimensions"),
        (antipodal(), FrictionlessPoint(), "wrenches span 1 of 6 dimensions"),
    ],
)
def test_a_flat_hull_has_no_volume(contacts: Contacts, model: ContactModel, reason: str) -> None:
    found = ferrari_canny(wrench_space(*contacts, model))
    assert (found.epsilon.value, found.epsilon.reason) == (0.0, reason)
    assert (found.volume.value, found.volume.reason) == (0.0, reason)


def test_a_flat_hull_beside_the_origin() -> None:
    """Forces that all have the same part downwards lie in one hyperplane."""
    found = ferrari_canny(wrench_space(*one_sided(), HardPoint(0.9)))
    assert (found.epsilon.value, found.epsilon.reason) == (0.0, "all forces in one half space")
    assert (found.volume.value, found.volume.reason) == (0.0, "the hull of the wrenches is flat")


def test_a_hull_beside_the_origin_has_a_volume() -> None:
    found = ferrari_canny(wrench_space(*coupled(turned=0.6), SoftFinger(0.5, 0.01)))
    assert (found.epsilon.value, found.epsilon.reason) == (0.0, "all wrenches in one half space")
    assert found.volume.value is not None
    assert found.volume.value > 0.0


def test_nothing_to_measure() -> None:
    found = ferrari_canny(wrench_space(np.zeros((0, 3)), np.zeros((0, 3)), HardPoint(0.5)))
    assert (found.epsilon.value, found.volume.value, found.epsilon.reason) == (None, None, "no contacts")


# Properties


@pytest.mark.slow
@given(
    seed=st.integers(0, 10_000),
    rotation=rotations,
    scale=st.floats(0.01, 100.0),
    model=st.sampled_from([0.2, 0.5, 1.0]),
)
@settings(max_examples=25, deadline=None)
def test_turning_moving_scaling_and_renaming_change_nothing(
    seed: int, rotation: Array, scale: float, model: float
) -> None:
    points, normals = random_contacts(seed, 4)
    order = np.random.default_rng(seed).permutation(4)
    moved = (scale * points @ rotation.T + 0.5)[order], (normals @ rotation.T)[order]
    one = ferrari_canny(wrench_space(points, normals, HardPoint(model, 8)))
    other = ferrari_canny(wrench_space(*moved, HardPoint(model, 8)))
    assert one.epsilon.value == pytest.approx(other.epsilon.value, abs=1e-9)
    assert one.volume.value == pytest.approx(other.volume.value, rel=1e-6)


@pytest.mark.slow
@given(seed=st.integers(0, 10_000), friction=st.floats(0.05, 1.0), more=st.floats(0.0, 1.0))
@settings(max_examples=25, deadline=None)
def test_more_friction_is_never_worse(seed: int, friction: float, more: float) -> None:
    contacts = random_contacts(seed, 3)
    one, other = (ferrari_canny(wrench_space(*contacts, HardPoint(value, 8))) for value in (friction, friction + more))
    assert one.epsilon.value is not None
    assert one.volume.value is not None
    assert other.epsilon.value is not None
    assert other.volume.value is not None
    assert other.epsilon.value >= one.epsilon.value - 1e-9
    assert other.volume.value >= one.volume.value - 1e-12


@pytest.mark.parametrize("length", [0.02, 0.5])
def test_the_volume_in_units_is_that_of_the_hull_of_wrenches_in_units(length: float) -> None:
    """Moments per newton in metres: three of the six dimensions are longer by the length."""
    space = wrench_space(*random_contacts(3, 4), HardPoint(0.5, 8), length=length)
    in_units = space.wrenches * np.array([1.0, 1.0, 1.0, length, length, length])
    volume = ferrari_canny(space).volume.value
    assert volume is not None
    assert volume * length**3 == pytest.approx(ConvexHull(in_units).volume, rel=1e-6)
