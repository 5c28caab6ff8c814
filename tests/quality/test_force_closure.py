"""Force closure against closed forms and against balances found another way."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import nnls

from graspdsl.arrays import Array
from graspdsl.quality.contact_models import ContactModel, FrictionlessPoint, HardPoint, SoftFinger
from graspdsl.quality.force_closure import force_closure
from graspdsl.quality.wrench_space import WrenchSpace, wrench_space
from quality.grasps import Contacts, antipodal, coupled, one_sided, random_contacts, raw, ring, rotations

SOFT = SoftFinger(0.5, 0.002)


def _none() -> Contacts:
    return np.zeros((0, 3)), np.zeros((0, 3))


@pytest.mark.parametrize(
    ("contacts", "model"),
    [(antipodal(), SOFT), (ring(), HardPoint(0.1)), (ring(), HardPoint(1.0)), (ring(4), HardPoint(0.3))],
)
def test_closed(contacts: Contacts, model: ContactModel) -> None:
    found = force_closure(wrench_space(*contacts, model))
    assert (found.closed, found.reason) == (True, "")
    assert found.margin is not None
    assert found.margin > 0.1


@pytest.mark.parametrize(
    ("contacts", "model", "reason"),
    [
        (antipodal(), FrictionlessPoint(), "wrenches span 1 of 6 dimensions"),
        (antipodal(), HardPoint(0.5), "wrenches span 5 of 6 dimensions"),
        (ring(), FrictionlessPoint(), "wrenches span 2 of 6 dimensions"),
        (one_sided(), HardPoint(0.9), "all forces in one half space"),
        (one_sided(), SOFT, "all forces in one half space"),
        (antipodal(turned=0.6), SOFT, "all forces in one half space"),
        (coupled(turned=0.6), SOFT, "all wrenches in one half space"),
        (random_contacts(0, 1), SOFT, "all forces in one half space"),
        (_none(), HardPoint(0.5), "no contacts"),
    ],
)
def test_not_closed_and_why(contacts: Contacts, model: ContactModel, reason: str) -> None:
    found = force_closure(wrench_space(*contacts, model))
    assert (found.closed, found.reason) == (False, reason)


def test_an_origin_on_the_boundary_is_not_closure() -> None:
    """A right-angled simplex with a corner at the origin, drawn as wrenches that balance only without one of them."""
    wrenches = np.vstack([np.eye(6), -np.eye(6)[:5]])
    found = force_closure(raw(wrenches))
    assert not found.closed
    assert found.reason.startswith("no wrench to spare")


def test_margin_of_an_even_balance_is_one() -> None:
    wrenches = np.vstack([np.eye(6), -np.eye(6)])
    assert force_closure(raw(wrenches)).margin == pytest.approx(1.0)


@pytest.mark.parametrize("friction", [0.2, 0.5, 1.0])
@pytest.mark.parametrize("beyond", [-0.01, 0.01])
def test_two_soft_contacts_are_closed_when_the_line_between_them_lies_in_both_cones(
    friction: float, beyond: float
) -> None:
    """Nguyen's theorem. Turned normals here lie in a plane that holds edges of the pyramids."""
    angle = math.atan(friction) + beyond
    for contacts in (antipodal(turned=angle), coupled(turned=angle)):
        found = force_closure(wrench_space(*contacts, SoftFinger(friction, 0.002)))
        assert found.closed == (beyond < 0.0)


def _balances_all(space: WrenchSpace) -> bool:
    """Whether non-negative combinations make every wrench ± e_i, by non-negative least squares."""
    return all(nnls(space.wrenches.T, sign * unit)[1] < 1e-9 for unit in np.eye(6) for sign in (1.0, -1.0))


@pytest.mark.parametrize("model", [HardPoint(0.3, 8), HardPoint(0.8, 8), SoftFinger(0.4, 0.01, 8), FrictionlessPoint()])
@pytest.mark.parametrize("count", [2, 3, 4, 7])
def test_closure_is_being_able_to_balance_every_wrench(model: ContactModel, count: int) -> None:
    for seed in range(12):
        space = wrench_space(*random_contacts(seed, count), model)
        assert force_closure(space).closed == _balances_all(space), seed


@pytest.mark.slow
@given(seed=st.integers(0, 10_000), rotation=rotations, scale=st.floats(0.01, 100.0), friction=st.floats(0.05, 1.5))
@settings(max_examples=30, deadline=None)
def test_turning_moving_scaling_and_renaming_change_nothing(
    seed: int, rotation: Array, scale: float, friction: float
) -> None:
    points, normals = random_contacts(seed, 3)
    order = np.random.default_rng(seed).permutation(3)
    moved = (scale * points @ rotation.T + 0.5)[order], (normals @ rotation.T)[order]
    one = force_closure(wrench_space(points, normals, HardPoint(friction)))
    other = force_closure(wrench_space(*moved, HardPoint(friction)))
    assert (one.closed, one.reason) == (other.closed, other.reason)
    assert one.margin == pytest.approx(other.margin, abs=1e-6)


@given(seed=st.integers(0, 10_000), friction=st.floats(0.05, 1.0), more=st.floats(0.0, 1.0))
@settings(max_examples=30, deadline=None)
def test_more_friction_never_opens_a_grasp(seed: int, friction: float, more: float) -> None:
    contacts = random_contacts(seed, 3)
    if force_closure(wrench_space(*contacts, HardPoint(friction))).closed:
        assert force_closure(wrench_space(*contacts, HardPoint(friction + more))).closed


@pytest.mark.parametrize("size", [1e-4, 1.0, 1e4])
def test_no_size_of_object_is_too_small_or_too_large(size: float) -> None:
    points, normals = ring(radius=size)
    assert force_closure(wrench_space(points, normals, HardPoint(0.5))).closed
    assert force_closure(wrench_space(points, normals, HardPoint(0.5), length=0.05)).closed
