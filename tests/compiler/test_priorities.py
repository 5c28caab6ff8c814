"""What ◁ promises: a lower level does not disturb a higher one, at any depth."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from graspdsl.arrays import Array

from .observations import FIRST, SECOND, THUMB, WEIGHTS, command, compiled, observation

PRESS = "φ_f|τ_f(γ3) σ_f(γ3) (κ_f σ_n(γ3))"
SECOND_LEVEL = "φ_p|τ_p(γ2) σ_p(γ2) (0.1, 0.2, 0.3)"
LOWEST = "φ_p|τ_p(γ1) σ_p(γ1) (0.3, 0.2, 0.1)"
TWO, THREE = f"{SECOND_LEVEL} ◁ {PRESS}", f"{LOWEST} ◁ {SECOND_LEVEL} ◁ {PRESS}"
SEEDS = range(10)
EACH_NULLSPACE = pytest.mark.parametrize("nullspace", ["task", "gradient"])


def null_space(jacobian: Array) -> Array:
    """I − J⁺J."""
    projector: Array = np.eye(jacobian.shape[1]) - np.linalg.pinv(jacobian) @ jacobian
    return projector


@pytest.mark.parametrize("virtual", ["members", "common"])
def test_sliding_does_not_press(virtual: str) -> None:
    """The means along the normals of each resource keep still: J_f N Δ = 0."""
    rows = {"members": [[THUMB], [FIRST], [SECOND]], "common": [[THUMB], [FIRST, SECOND]]}[virtual]
    for seed in SEEDS:
        seen = observation(seed)
        sliding, pressing = (
            command(f, seen, virtual=virtual, nullspace="task") for f in ("π_s|Γ Γ (π_gx|Γ Γ)", "π_close|Γ Γ")
        )
        depth = np.einsum("ki,kin,n->k", seen.normals, seen.jacobian, sliding - pressing)
        motion = seen.normals * depth[:, None]
        assert np.linalg.norm(sliding - pressing) > 1e-6
        assert np.abs([motion[row].mean(axis=0) for row in rows]).max() < 1e-9 * np.linalg.norm(sliding)


@EACH_NULLSPACE
def test_sliding_does_not_undo_the_force_step(nullspace: str) -> None:
    for seed in SEEDS:
        seen = observation(seed)
        slide, press = (command(f, seen, nullspace=nullspace) for f in ("π_s|Γ Γ (π_gx|Γ Γ)", "π_close|Γ Γ"))
        lower, higher = (slide - press) / WEIGHTS, press / WEIGHTS
        assert abs(lower @ higher) < 1e-9 * np.linalg.norm(lower) * np.linalg.norm(higher)


def test_each_level_but_the_lowest_is_certified() -> None:
    """Highest first, those of a chain in a reference too; of a chain in brackets each."""

    def certified(formula: str) -> list[str]:
        return [priority.controller.potential.symbol for priority in compiled(formula).priorities]

    assert certified(THREE) == ["φ_f", "φ_p"]
    assert certified(f"({LOWEST} ◁ {SECOND_LEVEL}) ◁ {PRESS}") == ["φ_f", "φ_p"]
    assert certified("π_s|Γ Γ (π_gx|Γ Γ)") == ["φ_fr", "φ_f"]
    assert certified(PRESS) == []


def test_a_chain_holds_where_nested_projection_leaks() -> None:
    for seed in SEEDS:
        seen = observation(seed)
        three, two, one, alone = (command(f, seen, nullspace="task") / WEIGHTS for f in (THREE, TWO, PRESS, LOWEST))
        lowest, middle = three - two, two - one
        press_task = (seen.normals[SECOND] @ seen.jacobian[SECOND] * WEIGHTS)[None]
        second_task = seen.jacobian[FIRST] * WEIGHTS
        assert np.linalg.norm(press_task @ middle) < 1e-9 * np.linalg.norm(middle)
        for task in (press_task, second_task):
            assert np.linalg.norm(task @ lowest) < 1e-9 * np.linalg.norm(lowest)
        stacked = null_space(np.vstack([press_task, second_task])) @ alone
        np.testing.assert_allclose(lowest, stacked, atol=1e-9 * np.linalg.norm(alone))
        nested = null_space(press_task) @ null_space(second_task) @ alone
        assert np.linalg.norm(second_task @ nested) > 1e-4 * np.linalg.norm(nested)


@pytest.mark.slow
def test_lower_levels_reach_their_goals_with_the_freedom_that_is_left() -> None:
    """Ten joints in a linear world have enough of it for one force and two positions."""
    pipeline, seen = compiled(THREE, nullspace="task", cap=0.1), observation()
    seen.forces[:] = 0.5 * seen.normals
    for _ in range(2000):
        step = pipeline.evaluate(seen).command.displacement
        seen.points[:] += seen.jacobian @ step
        assert abs(seen.normals[SECOND] @ seen.jacobian[SECOND] @ step) < 1e-9
    np.testing.assert_allclose(seen.points[FIRST], [0.1, 0.2, 0.3], atol=1e-4)
    np.testing.assert_allclose(seen.points[THUMB], [0.3, 0.2, 0.1], atol=1e-4)


@EACH_NULLSPACE
def test_without_a_virtual_contact_projection_changes_nothing(nullspace: str) -> None:
    """Both residual gradients are normal to each other then, so that ◁ is a sum and its order does not matter."""
    plain = "{γ1, γ2, γ3}"
    parts = [f"φ_mr|τ_mrx({plain}) σ_mr({plain})", f"φ_fr|τ_frx({plain}) σ_fr({plain})"]
    for seed in SEEDS:
        seen = observation(seed)
        moment, force = (command(part, seen, nullspace=nullspace, cap=0.1) for part in parts)
        assert abs(np.sum(moment * force)) < 1e-12 * np.linalg.norm(moment) * np.linalg.norm(force)
        if nullspace == "gradient":
            for order in (parts, parts[::-1]):
                found = command(" ◁ ".join(order), seen, nullspace=nullspace, cap=0.1)
                np.testing.assert_allclose(found, moment + force, atol=1e-12 * np.linalg.norm(found))


@EACH_NULLSPACE
@pytest.mark.parametrize("virtual", ["members", "common"])
def test_with_a_virtual_contact_projection_acts(virtual: str, nullspace: str) -> None:
    """Its members' weights take the right angle between the two gradients away."""
    settings = {"virtual": virtual, "nullspace": nullspace, "cap": 0.1}
    for seed in SEEDS:
        seen = observation(seed)
        both, force, moment = (
            command(f, seen, **settings) for f in ("π_gx|Γ Γ", "φ_fr|τ_frx(Γ) σ_fr(Γ)", "φ_mr|τ_mrx(Γ) σ_mr(Γ)")
        )
        change = np.linalg.norm(both - force - moment) / np.linalg.norm(moment)
        assert change > 1e-4


def test_a_gradient_that_has_vanished_takes_no_freedom_away() -> None:
    """A force servo at its goal has no direction of its own."""
    seen = observation()
    seen.forces[:] = 0.5 * seen.normals
    slide, move = (
        command(f, seen, nullspace="gradient") for f in ("π_s|Γ Γ (π_gx|Γ Γ)", "φ_p|τ_p(Γ) σ_p(Γ) (π_gx|Γ Γ)")
    )
    np.testing.assert_allclose(slide, move, atol=1e-9 * np.linalg.norm(move))


@EACH_NULLSPACE
def test_levels_of_joints_and_of_contacts_take_batches(nullspace: str) -> None:
    """A posture's task is the same for all observations, those of contacts are not: the commands are as one by one."""
    pipeline = compiled("φ_k|τ_k(all) σ_k(flexion) ◁ π_close|Γ Γ", nullspace=nullspace)
    alone = [observation(seed) for seed in range(3)]
    fields = {f.name: np.stack([getattr(seen, f.name) for seen in alone]) for f in dataclasses.fields(alone[0])}
    whole = pipeline.values(dataclasses.replace(alone[0], **fields))[pipeline.command]
    one_by_one = [pipeline.values(seen)[pipeline.command] for seen in alone]
    np.testing.assert_allclose(whole, one_by_one, atol=1e-14)
