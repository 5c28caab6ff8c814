"""What a command does not depend on, and what it does when a contact is lost."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from graspdsl.basis.operations import SHORT_REACH
from graspdsl.worlds.protocol import Observation

from .observations import CONTACTS, ROBOT, TARGET, WEIGHTS, command, observation, rotated

SLIDE = "π_s|Γ Γ (π_gx|Γ Γ)"
JOINTS = list(ROBOT.joints)
OWN = [{JOINTS.index(joint) for joint in contact.finger} for contact in ROBOT.hand.contacts.values()]
SPEED = 0.05
FASTEST = SPEED / TARGET.rate
EACH_FORM = pytest.mark.parametrize("nullspace", ["task", "gradient"])
EACH_ORIGIN = pytest.mark.parametrize("origin", ["centroid", "world"])


@EACH_FORM
@EACH_ORIGIN
@pytest.mark.parametrize("virtual", ["members", "common"])
def test_gradient_turns_with_the_world_frame(nullspace: str, origin: str, virtual: str) -> None:
    settings = {"nullspace": nullspace, "origin": origin, "virtual": virtual}
    for seed, turn in enumerate(Rotation.random(10, random_state=1).as_matrix()):
        seen = observation(seed)
        found = command("π_gx|Γ Γ", rotated(seen, turn), **settings)
        expected = command("π_gx|Γ Γ", seen, **settings) @ turn.T
        assert np.abs(found - expected).max() < 1e-12 * np.linalg.norm(expected)


@EACH_FORM
def test_joints_do_not_care_for_the_world_frame(nullspace: str) -> None:
    for seed, turn in enumerate(Rotation.random(10, random_state=1).as_matrix()):
        seen = observation(seed)
        seen.touching[0] = seed % 2 == 0
        found, expected = (command(SLIDE, one, nullspace=nullspace) for one in (rotated(seen, turn), seen))
        assert np.abs(found - expected).max() < 1e-9 * np.linalg.norm(expected)


def test_about_the_centroid_it_does_not_matter_where_the_world_is() -> None:
    seen = observation()
    shifted = replace(seen, points=seen.points + np.array([1.0, -2.0, 3.0]))
    here, there = (command("π_gx|Γ Γ", one) for one in (seen, shifted))
    np.testing.assert_allclose(here, there, atol=1e-12)
    here, there = (command("π_gx|Γ Γ", one, origin="world") for one in (seen, shifted))
    assert np.abs(here - there).max() > 1e-3


def _lost(*contacts: int) -> Observation:
    seen = observation()
    seen.touching[list(contacts)] = False
    seen.forces[list(contacts)] = 0.0
    return seen


@EACH_FORM
@pytest.mark.parametrize("lost", [(0,), (1,), (2,), (0, 2), (0, 1, 2)])
def test_only_its_own_finger_closes_when_a_contact_is_lost(lost: tuple[int, ...], nullspace: str) -> None:
    """The others press on as before, which is nothing when their forces are right; nothing slides."""
    seen = _lost(*lost)
    touching = seen.touching
    seen.forces[touching] = 0.5 * seen.normals[touching]
    step = command(SLIDE, seen, nullspace=nullspace)
    own = sorted(set().union(*(OWN[contact] for contact in lost)))
    assert np.all(np.abs(step[own]) > 0.0)
    np.testing.assert_allclose(np.delete(step, own), 0.0, atol=1e-15)


@EACH_FORM
def test_touching_contacts_go_on_pressing_when_another_is_lost(nullspace: str) -> None:
    seen = _lost(1)
    slide, press = (command(f, seen, nullspace=nullspace, admittance=1e-5) for f in (SLIDE, "π_close|Γ Γ"))
    np.testing.assert_allclose(slide, press, atol=1e-15)
    approach = np.isin(np.arange(len(JOINTS)), sorted(OWN[1]))
    servo = np.where(approach, 0.0, press)
    assert np.linalg.norm(servo) > 0.0
    forces = seen.normals * np.einsum("ki,ki->k", seen.normals, seen.forces)[:, None]
    error = np.where(seen.touching[:, None], 0.5 * seen.normals - forces, 0.0)
    asked = 1e-5 * WEIGHTS**2 * np.einsum("kin,ki->n", seen.jacobian, error)
    np.testing.assert_allclose(servo, np.where(approach, 0.0, asked), atol=1e-12)


def test_nobody_waits_for_a_contact_of_another_controller() -> None:
    formula = "φ_p|τ_p({γ1, γ3}) σ_p({γ1, γ3}) (0.1, 0.2, 0.3, 0.4, 0.5, 0.6)"
    first, second = (ROBOT.contacts.index(name) for name in ("finger-1", "finger-2"))
    np.testing.assert_array_equal(command(formula, _lost(first)), command(formula, observation()))
    np.testing.assert_array_equal(command(formula, _lost(second)), 0.0)


def test_a_lost_contact_nears_along_its_normal_at_the_speed_of_approach() -> None:
    for lost in range(CONTACTS):
        seen = _lost(lost)
        seen.jacobian[lost] *= 10.0  # a finger that reaches well
        seen.forces[seen.touching] = 0.5 * seen.normals[seen.touching]
        step = command("π_close|Γ Γ", seen, approach=SPEED)
        nearer = seen.normals[lost] @ seen.jacobian[lost] @ step
        np.testing.assert_allclose(nearer, FASTEST, rtol=1e-9)


def test_a_finger_that_cannot_reach_is_not_driven_fast() -> None:
    steps = []
    for scale in np.logspace(2, -6, 60):
        seen = _lost(0)
        seen.forces[seen.touching] = 0.5 * seen.normals[seen.touching]
        seen.jacobian[0] *= scale
        steps.append(np.abs(command("π_close|Γ Γ", seen, approach=SPEED) / WEIGHTS).max())
    assert max(steps) <= FASTEST / np.sqrt(SHORT_REACH)
    assert steps[-1] < 1e-5 * max(steps)


def test_force_servo_is_no_faster_than_the_approach() -> None:
    seen = observation()
    seen.forces[:] = -1e6 * seen.normals
    step = command("φ_f|τ_f(γ1) σ_f(γ1) (κ_f σ_n(γ1))", seen, approach=SPEED)
    thumb = ROBOT.contacts.index("finger-3")
    np.testing.assert_allclose(step, FASTEST * WEIGHTS**2 * (seen.normals[thumb] @ seen.jacobian[thumb]), rtol=1e-9)


def test_no_contact_moves_further_than_the_cap() -> None:
    seen = observation()
    settings = {"step": 0.1, "damping": 1e-6}
    step = command("φ_p|τ_p(Γ) σ_p(Γ) (π_gx|Γ Γ)", seen, cap=2e-4, **settings)
    moved = np.linalg.norm(seen.jacobian @ step, axis=-1)
    np.testing.assert_allclose(moved.max(), 2e-4, rtol=1e-4)
