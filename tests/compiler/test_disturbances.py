"""What a command does to the levels that others are subject to, against what each alone would have been commanded.

Each is held against two other pipelines, of the whole formula and of the level alone, and against how contacts move.
"""

from __future__ import annotations

import numpy as np
import pytest

from graspdsl.arrays import Array
from graspdsl.worlds.protocol import Observation

from .observations import CONTACTS, FIRST, LOWER, SECOND, THUMB, UPPER, command, compiled, observation, one_of

PRESS = "φ_f|τ_f({γ1, γ2, γ3}) σ_f({γ1, γ2, γ3}) (κ_f σ_n({γ1, γ2, γ3}))"
MOVE = "φ_p|τ_p({γ1, γ2}) σ_p({γ1, γ2}) (0.1, 0.2, 0.3, 0, 0.1, 0.2)"
SLIDE = f"{MOVE} ◁ {PRESS}"
FORCE, MOMENT = "φ_fr|τ_frx(Γ) σ_fr(Γ)", "φ_mr|τ_mrx(Γ) σ_mr(Γ)"
WEIGHTS = np.zeros(CONTACTS)
WEIGHTS[[THUMB, FIRST, SECOND]] = 1.0, 0.5, 0.5
RADIUS, FAR = 0.05, 0.1  # m: of the ball that gradients assume; a cap that nothing meets
SEEDS = range(5)


def pressed(seen: Observation, step: Array) -> Array:
    """How far joints press contacts into the surface, along the normals, (k, 3) [m]."""
    moved: Array = seen.jacobian @ step
    along: Array = np.sum(moved * seen.normals, axis=-1, keepdims=True) * seen.normals
    return along


def turned(seen: Observation, moved: Array) -> Array:
    """How contacts that move by (k, 3) [m] over a ball change the net of their inward unit normals, (3,)."""
    tangent = moved - np.sum(moved * seen.normals, axis=-1, keepdims=True) * seen.normals
    change: Array = -WEIGHTS @ tangent / RADIUS
    return change


def length(vector: Array) -> float:
    return float(np.linalg.norm(vector))


def test_nothing_disturbs_what_its_task_is_kept_from() -> None:
    """Without a cap, a locked joint or a gradient in place of a task."""
    for formula, cap in ((SLIDE, 7.5e-4), (f"{MOMENT} ◁ {FORCE}", FAR)):
        for seed in SEEDS:
            tick = compiled(formula, nullspace="task", cap=cap).evaluate(observation(seed))
            assert not tick.locked.any()
            assert max(tick.disturbances) < 1e-12


def test_the_gradient_of_three_pressing_contacts_is_one_direction_of_nine() -> None:
    for seed in SEEDS:
        seen = observation(seed)
        whole, alone = (command(formula, seen, nullspace="gradient") for formula in (SLIDE, PRESS))
        (found,) = compiled(SLIDE, nullspace="gradient").evaluate(seen).disturbances
        assert found == pytest.approx(length(pressed(seen, whole - alone)), rel=1e-9)
        assert found > 0.1 * length(pressed(seen, alone))


@pytest.mark.parametrize("nullspace", ["task", "gradient"])
def test_a_cap_shortens_the_level_itself(nullspace: str) -> None:
    """The moment's part leaves the force's no room."""
    pipeline = compiled(f"{MOMENT} ◁ {FORCE}", nullspace=nullspace, cap=1e-4, step=1e-3, moment_gain=30.0)
    for seed in SEEDS:
        seen = observation(seed)
        settings = {"nullspace": nullspace, "cap": 1e-4, "step": 1e-3, "moment_gain": 30.0}
        whole, alone = (command(formula, seen, **settings) for formula in (f"{MOMENT} ◁ {FORCE}", FORCE))
        ticks = pipeline.ticks(seen)
        lower, cap, locked = ticks.parts[0]
        np.testing.assert_allclose(lower + cap + locked, turned(seen, whole - alone), atol=1e-12)
        np.testing.assert_allclose(ticks.own[0], turned(seen, alone), atol=1e-12)
        assert length(cap) > 0.1 * length(ticks.own[0])
        assert nullspace == "gradient" or length(lower) < 1e-12


@pytest.mark.parametrize("nullspace", ["task", "gradient"])
def test_a_chain_in_a_reference_is_certified_by_how_joints_move_its_contacts(nullspace: str) -> None:
    """Alone, the inner level goes the same way: through the outer inverse and the outer null space."""
    pipeline = compiled(f"π_s|Γ Γ ({MOMENT} ◁ {FORCE})", nullspace=nullspace)
    for seed in SEEDS:
        seen = observation(seed)
        whole, alone = (
            command(f"π_s|Γ Γ ({inner})", seen, nullspace=nullspace) for inner in (f"{MOMENT} ◁ {FORCE}", FORCE)
        )
        inner, _ = pipeline.evaluate(seen).disturbances
        assert inner == pytest.approx(length(turned(seen, seen.jacobian @ (whole - alone))), rel=1e-9)
        assert inner > 0.0


def test_a_joint_that_a_lower_level_locks_is_missed_by_a_higher_one() -> None:
    """Where the thumb's joint stands at a limit that only the lower level would have it pass."""
    made, press = (compiled(formula, nullspace="task") for formula in (SLIDE, PRESS))
    disturbed = 0
    for seed in range(30):
        seen = observation(seed)
        free, alone = made.evaluate(seen), press.evaluate(seen).command.displacement
        whole = free.command.displacement
        joint = int(np.argmax(np.abs(whole)))
        if whole[joint] * alone[joint] >= 0.0:
            continue
        seen.joints[joint] = UPPER[joint] if whole[joint] > 0.0 else LOWER[joint]
        tick = made.evaluate(seen)
        assert tick.locked[joint]
        apart = tick.command.displacement - press.evaluate(seen).command.displacement
        assert tick.disturbances[0] == pytest.approx(length(pressed(seen, apart)), rel=1e-6)
        assert tick.disturbances[0] > 1e3 * free.disturbances[0]
        disturbed += 1
    assert disturbed > 5


def test_what_both_lock_disturbs_nothing() -> None:
    """A joint that the level alone would have locked, too."""
    formula = f"{PRESS} ◁ {PRESS}"
    for seed in SEEDS:
        seen = observation(seed)
        step = command(PRESS, seen)
        joint = int(np.argmax(np.abs(step)))
        seen.joints[joint] = UPPER[joint] if step[joint] > 0.0 else LOWER[joint]
        tick = compiled(formula, nullspace="task").evaluate(seen)
        assert tick.locked[joint]
        assert max(tick.disturbances) < 1e-12


@pytest.mark.parametrize("formula", [SLIDE, f"{MOMENT} ◁ {FORCE}", f"π_s|Γ Γ ({MOMENT} ◁ {FORCE})"])
def test_disturbances_of_a_batch_are_those_of_its_members(formula: str) -> None:
    """To the last bit, whichever joints the others lock."""
    pipeline, batch = compiled(formula), observation(3, 5)
    batch.joints[1:3] = UPPER
    ticks = pipeline.ticks(batch)
    for index in range(5):
        one = pipeline.ticks(one_of(batch, index))
        for name in ("displacement", "sensed", "effects", "own", "parts", "ranks"):
            np.testing.assert_array_equal(getattr(ticks, name)[index], getattr(one, name))


def test_what_is_not_asked_for_is_not_worked_out() -> None:
    pipeline, seen = compiled(SLIDE), observation()
    bare, whole = pipeline.ticks(seen, certified=False), pipeline.ticks(seen)
    np.testing.assert_array_equal(bare.displacement, whole.displacement)
    np.testing.assert_array_equal(bare.ranks, whole.ranks)
    assert bare.parts.shape[0] == 0
    assert whole.parts.shape[0] == 1
    assert len(pipeline.values(seen, certified=False)) == pipeline.bare < len(pipeline.steps)
