"""What a trial is: the same alone and among others, stage after stage, back again, and when its end conditions hold."""

from __future__ import annotations

import dataclasses
import itertools
import math
import re
import time
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from worlds.floating_runs import ELLIPSOID_B, HOLD, RADIUS, SPHERE, contacts, ends, pipelines, run, starts

from graspdsl.compiler.pipeline import Ticks
from graspdsl.compiler.program import Program, program_of
from graspdsl.spec.program import Until
from graspdsl.trials.end_conditions import is_low, unmet
from graspdsl.trials.loop import TrialLoop, together
from graspdsl.trials.outcomes import Outcome
from graspdsl.trials.record import Trial
from graspdsl.trials.setup import settings_of, trial_loop
from graspdsl.worlds.floating import Floating, FloatingWorld
from graspdsl.worlds.mujoco.kind import Mujoco
from graspdsl.worlds.mujoco.stage import MujocoStage
from graspdsl.worlds.mujoco.stages import MujocoEngine
from graspdsl.worlds.protocol import Command, InfeasibleStartError, Observation, Start
from graspdsl.worlds.rigid.world import RigidWorld

SPECS = Path(__file__).parents[2] / "specs"
FORMULAS = ["π_gx|Γ Γ", "π_cstar|Γ Γ", "φ_w|τ_wx(Γ) σ_w(Γ)"]
EACH_FORMULA = pytest.mark.parametrize("formula", FORMULAS)


def program(name: str, *overrides: str) -> Program:
    """One of the example specs."""
    return program_of((SPECS / name).read_text("utf-8"), name, overrides)


def timeless(trial: Trial) -> tuple[str, dict[str, bytes]]:
    """All of a trial but how long the computer took."""
    record = dataclasses.replace(trial.record, wall_s=0.0)
    return repr(record.as_dict()), {name: rows.tobytes() for name, rows in trial.trajectory.items()}


# Alone and among others

FORCE = "{run: φ_fr|τ_frx(Γ) σ_fr(Γ), until: {force_residual: 0.3, hold: 0.1}, limit: 1.0}"
BOTH = "{run: π_gx|Γ Γ, until: {force_residual: 0.1, moment_residual: 0.005, hold: 0.4}, limit: 2.0}"
BOX = "{superquadric: {size: [0.1, 0.15, 0.22], exponent: 6.0}}"
PROGRAMS = [
    program("chapter/4_18_grasp.yaml", "program.0.limit=2.0"),
    program("compare/cstar.yaml", "program.0.hysteresis=1.05", "program.0.limit=2.0"),
    program(
        "compare/cstar.yaml",
        "monitors.progress={window: 0.5}",
        "evaluate=[force-closure, ferrari-canny]",
        "program.0.limit=2.0",
    ),
    program("compare/moment_subject_to_force.yaml", f"program=[{FORCE}, {BOTH}]", "scene.object=bottle"),
    program(
        "compare/moment_subject_to_force.yaml", f"scene.object={BOX}", "control.nullspace=task", "program.0.limit=2.0"
    ),
]
ALONE: dict[tuple[int, int], tuple[str, dict[str, bytes]]] = {}


@pytest.mark.slow
@settings(max_examples=10, deadline=None)
@given(
    which=st.integers(0, len(PROGRAMS) - 1), first=st.integers(0, 4), count=st.integers(1, 9), size=st.integers(1, 9)
)
def test_a_trial_is_the_same_to_the_last_bit_among_any_others(which: int, first: int, count: int, size: int) -> None:
    loop = trial_loop(PROGRAMS[which])
    loop.together = size
    found = {trial.record.number: timeless(trial) for trial in loop.run_all(range(first, first + count), 7)}
    assert sorted(found) == list(range(first, first + count))
    for number, trial in found.items():
        if (which, number) not in ALONE:
            ALONE[which, number] = timeless(trial_loop(PROGRAMS[which]).run(number, 7))
        assert trial == ALONE[which, number]


@pytest.mark.parametrize("name", ["compare/cstar_hysteresis.yaml", "chapter/4_30_grasp_cartesian.yaml"])
def test_what_follows_is_the_same_however_many_ticks_are_worked_on_at_once(
    name: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Also where stages go forth and back, and where others end."""
    made, found = program(name, "program.0.limit=3.0"), []
    for rows in (1, 7, 64):
        monkeypatch.setattr("graspdsl.trials.tick_rows.ENOUGH", rows)
        found.append([timeless(trial) for trial in trial_loop(made).run_all(range(3), 7)])
    assert found[0] == found[1] == found[2]


SHORT = ("program.1.limit=0.6", "trials.start.roll=0.3", "trials.start.standoff=0.05")
TOWEL_ROLL = program(
    "towel_roll_two_contacts.yaml",
    "scene.world=mujoco",
    "scene.sensing={load-cell: {force_noise: 0.02, force_drift: 0.001}}",
    "evaluate=[ferrari-canny, lift]",
    *SHORT,
)


@pytest.mark.slow
def test_a_trial_of_rigid_bodies_is_the_same_to_the_last_bit_beside_others() -> None:
    """With sensors that are random, and lifted at its end while others still run; the third begins where one ends."""
    loop = trial_loop(TOWEL_ROLL)
    loop.together = 2
    found = {trial.record.number: timeless(trial) for trial in loop.run_all(range(3), 7)}
    assert found == {number: timeless(trial_loop(TOWEL_ROLL).run(number, 7)) for number in range(3)}


class Crashing(RigidWorld):
    """A world whose second trial leaves the realm of numbers at its fortieth tick."""

    def step(self, command: Command) -> Observation:
        """One tick."""
        for second in self._trials[1:2]:
            assert isinstance(second.stage, MujocoStage)
            if second.ticks == 40:
                second.stage.state.data.qvel[0] = np.nan
        return super().step(command)


@pytest.mark.slow
def test_a_trial_that_crashes_leaves_those_beside_it_alone() -> None:
    engine = MujocoEngine(Mujoco.effort)
    found = list(TrialLoop(TOWEL_ROLL, Crashing(engine, settings_of(TOWEL_ROLL))).run_all(range(3), 7))
    crashed, *others = found
    assert crashed.record.number == 1
    assert crashed.record.outcome is Outcome.CRASHED
    assert "numbers" in crashed.record.detail
    whole = {trial.record.number: timeless(trial) for trial in trial_loop(TOWEL_ROLL).run_all(range(3), 7)}
    assert {trial.record.number: timeless(trial) for trial in others} == {0: whole[0], 2: whole[2]}


def test_trials_side_by_side_share_the_time_they_take() -> None:
    began = time.perf_counter()
    shares = [trial.record.wall_s for trial in trial_loop(PROGRAMS[0]).run_all(range(8), 7)]
    assert min(shares) > 0.0
    assert sum(shares) <= time.perf_counter() - began


def test_trials_come_as_they_end() -> None:
    """Not in the order of their numbers, so that what is finished can be kept while others still run."""
    trials = list(trial_loop(PROGRAMS[0]).run_all(range(12), 7))
    ticks = [len(trial.trajectory["time"]) for trial in trials]
    assert ticks == sorted(ticks)
    assert [trial.record.number for trial in trials] != list(range(12))


def test_a_batch_stays_full_while_trials_wait(monkeypatch: pytest.MonkeyPatch) -> None:
    """Others begin at the places of those that end, several at once where there are many places."""
    loop, rows, step = trial_loop(PROGRAMS[0]), list[int](), FloatingWorld.step
    loop.together, places = 32, 30

    def stepped(world: FloatingWorld, command: Command) -> Observation:
        rows.append(len((seen := step(world, command)).time))
        return seen

    monkeypatch.setattr(FloatingWorld, "step", stepped)
    ticks = [len(trial.trajectory["time"]) for trial in loop.run_all(range(96), 7)]
    full = max(tick for tick, count in enumerate(rows) if count > places)
    assert len(set(ticks)) > 1
    assert min(rows[: full + 1]) > places
    assert full > max(ticks)


class Refusing(FloatingWorld):
    """A world that takes up no start but every fourth."""

    asked = 0

    def join(self, start: Start, seed: int) -> None:
        """One more trial, maybe."""
        self.asked += 1
        if self.asked % 4:
            raise InfeasibleStartError("not this one")
        super().join(start, seed)


def test_trials_that_cannot_begin_keep_no_other_from_it() -> None:
    """Though they were to take all places."""
    made = PROGRAMS[0]
    world = Refusing(made.robot.contacts, made.body.shape.surface(), 1.0)
    loop = TrialLoop(made, world, most_draws=1)
    loop.together = 2
    found = {trial.record.number: trial.record.has_begun for trial in loop.run_all(range(12), 7)}
    assert found == {number: number % 4 == 3 for number in range(12)}


def test_trials_that_take_long_are_fewer_side_by_side() -> None:
    """So that their trajectories fit into memory; where contacts are probed, each trial takes its own time."""
    assert together(program("chapter/4_30_grasp_cartesian.yaml", "program.0.limit=2.0")) == Floating.together
    assert together(program("compare/cstar.yaml")) < Floating.together
    assert together(program("compare/cstar.yaml", "program.0.limit=600")) < 10
    assert together(program("towel_roll_two_contacts.yaml")) > 1
    assert together(program("compare/probing.yaml")) == 1


# Many starts on known surfaces


@EACH_FORMULA
def test_starts_are_left_as_they_were(formula: str) -> None:
    points = starts(ELLIPSOID_B, 5)
    before = points.copy()
    ends(formula, 3, ELLIPSOID_B, points, steps=30)
    np.testing.assert_array_equal(points, before)


@pytest.mark.slow
def test_contacts_go_where_the_pipeline_step_by_step_takes_them() -> None:
    (pipeline,), points, steps = pipelines("π_gx|Γ Γ", contacts(3)), starts(ELLIPSOID_B, 40), 120
    found = ends("π_gx|Γ Γ", 3, ELLIPSOID_B, points, steps=steps, force_residual=1e-300)
    np.testing.assert_array_equal(found.points, run(pipeline, ELLIPSOID_B, points, steps).points)


def test_ticks_tell_from_when_on_residuals_stayed_low() -> None:
    """Bounds on the force alone, so that the run step by step says when."""
    (pipeline,), points = pipelines("π_fr|Γ Γ", contacts(3)), starts(SPHERE, 40)
    errors = run(pipeline, SPHERE, points, 200).force_errors
    for bound in (0.3, 1e-3):
        found = ends("π_fr|Γ Γ", 3, SPHERE, points, force_residual=bound, moment_residual=np.inf, steps=199)
        high = np.sqrt(errors) >= bound
        since = len(errors) - np.argmax(high[::-1], axis=0)  # the residual never rises
        np.testing.assert_array_equal(found.ticks, np.where(high.any(axis=0), since, 0))
        assert found.converged.all()


@pytest.mark.slow
@EACH_FORMULA
def test_what_has_converged_had_time_to_hold(formula: str) -> None:
    found = ends(formula, 3, ELLIPSOID_B, starts(ELLIPSOID_B, 100))
    assert np.all(found.ticks[found.converged] <= 1000 - HOLD + 1)


EVERYTHING = {"force_residual": 9.0, "moment_residual": 0.5}


def test_bounds_that_nothing_meets_or_everything() -> None:
    (pipeline,), points = pipelines("π_gx|Γ Γ", contacts(3)), starts(ELLIPSOID_B, 10)
    never = ends("π_gx|Γ Γ", 3, ELLIPSOID_B, points, force_residual=1e-300, moment_residual=1e-300, steps=50)
    assert not never.converged.any()
    always = ends("π_gx|Γ Γ", 3, ELLIPSOID_B, points, steps=50, **EVERYTHING)
    assert always.converged.all()
    assert np.all(always.ticks == 0)
    np.testing.assert_array_equal(always.points, run(pipeline, ELLIPSOID_B, points, HOLD - 1).points)


def test_too_few_steps_to_hold_are_not_enough() -> None:
    points = starts(ELLIPSOID_B, 10)
    for steps, enough in ((18, False), (19, True)):
        found = ends("π_gx|Γ Γ", 3, ELLIPSOID_B, points, steps=steps, **EVERYTHING)
        assert found.converged.all() == enough == found.converged.any()


def test_each_stage_has_to_hold_anew() -> None:
    """Where everything is low, the second stage begins in the step in which the first has held, and counts from one."""
    points = starts(ELLIPSOID_B, 10)
    found = ends("π_cstar|Γ Γ", 3, ELLIPSOID_B, points, steps=50, **EVERYTHING)
    assert found.converged.all()
    assert np.all(found.ticks == HOLD - 1)
    short = ends("π_cstar|Γ Γ", 3, ELLIPSOID_B, points, steps=2 * HOLD - 3, **EVERYTHING)
    assert not short.converged.any()


def test_a_stage_begins_when_the_one_before_has_held() -> None:
    """The force's stage of C* lasts as long as the force controller alone; only then does the moment's move."""
    points = starts(ELLIPSOID_B, 30)
    alone = ends("φ_fr|τ_frx(Γ) σ_fr(Γ)", 3, ELLIPSOID_B, points, moment_residual=np.inf)
    assert alone.converged.all()
    first = int(alone.ticks.max()) + HOLD - 1
    both = ends("π_cstar|Γ Γ", 3, ELLIPSOID_B, points, steps=first)
    latest = alone.ticks == alone.ticks.max()
    np.testing.assert_allclose(both.points[latest], alone.points[latest], atol=1e-14)
    assert np.abs(both.points - alone.points)[alone.ticks < alone.ticks.max()].max() > 1e-3 * RADIUS


# Back again


def stages(trial: Trial, residual: str, high: float) -> list[bool]:
    """Whether a sensed residual is high, tick by tick, each change once."""
    norms = np.linalg.norm(trial.trajectory[residual], axis=-1)
    return [is_high for is_high, _ in itertools.groupby(norms > high)]


@pytest.mark.slow
def test_hysteresis_goes_back_a_stage() -> None:
    """Moment alone undoes the force residual that the stage before had brought down: with hysteresis, not for long."""
    more = ("program.0.limit=10.0", "program.0.until.moment_residual=1e-6", "monitors.progress=off")
    given_up, kept = (
        trial_loop(program("compare/cstar.yaml", *more, *hysteresis)).run(0, 5)
        for hysteresis in ((), ("program.0.hysteresis=1.5",))
    )
    worst = [
        np.linalg.norm(trial.trajectory["sensed_force_residual"][-100:], axis=-1).max() for trial in (given_up, kept)
    ]
    assert worst[0] > 0.3
    assert worst[1] < 0.25
    assert len(stages(kept, "sensed_force_residual", 0.15)) > 3


@pytest.mark.slow
def test_what_a_later_stage_raises_again_is_undone_and_hysteresis_cures_it() -> None:
    """The moment alone gives up the force residual: told from what to what, as the trajectory has it."""
    plain, curing = (
        list(trial_loop(program("compare/cstar.yaml", *more)).run_all(range(8), 31))
        for more in ((), ("program.0.hysteresis=1.5",))
    )
    undone = [trial for trial in plain if trial.record.outcome is Outcome.UNDONE]
    assert undone
    for trial in undone:
        residual, stage = np.linalg.norm(trial.trajectory["sensed_force_residual"], axis=-1), trial.trajectory["stage"]
        before, bound, now = map(float, re.findall(r"0\.\d+", trial.record.detail))
        assert before < bound == 0.1 <= now
        assert before == pytest.approx(residual[np.argmax(stage == 1)], rel=5e-3)
        assert now == pytest.approx(residual[-1], rel=5e-3)
        assert "stage 2 of 2 raised it; with hysteresis the phase goes back" in trial.record.detail
    good = [sum(trial.record.outcome is Outcome.CONVERGED for trial in trials) for trials in (plain, curing)]
    assert good[1] > good[0]
    assert all(trial.record.outcome is not Outcome.UNDONE for trial in curing)


@pytest.mark.slow
def test_what_ends_in_an_earlier_stage_or_keeps_what_was_lowered_is_not_undone() -> None:
    """The moment of two contacts leaves the force alone at first: time is up, in the stage that is named."""
    first = "program.0.until={force_residual: 1e-9, moment_residual: 0.005}"
    trial = trial_loop(program("compare/cstar.yaml", first, "program.0.limit=1.0")).run(0, 31)
    assert trial.record.outcome is not Outcome.UNDONE
    assert trial.record.detail.startswith("in stage 1 of 2: ")
    late = "program.0.until={force_residual: 0.9, moment_residual: 1e-9, hold: 0}"
    trial = trial_loop(program("compare/cstar.yaml", late, "program.0.limit=0.3")).run(0, 31)
    assert trial.record.outcome is Outcome.TIMEOUT
    assert trial.record.detail.startswith("in stage 2 of 2: not converged")


# The whole time

FULL_TIME = ("program.0.full_time=true",)


def test_a_phase_of_full_time_is_judged_at_its_limit() -> None:
    """It goes the way of one that ends early, and on; whether it converged is told of where it is then."""
    formula = "compare/force_alone.yaml"
    bounds = ("program.0.until={force_residual: 0.1, hold: 0.4}", "program.0.limit=12.0")
    early, whole = (trial_loop(program(formula, *bounds, *more)).run(0, 5) for more in ((), FULL_TIME))
    assert (early.record.outcome, whole.record.outcome) == (Outcome.CONVERGED, Outcome.CONVERGED)
    assert early.record.world_s < whole.record.world_s == 12.0
    shared = len(early.trajectory["time"])
    assert np.array_equal(early.trajectory["points"], whole.trajectory["points"][:shared])
    assert early.record.ticks_to_converge == whole.record.ticks_to_converge
    assert whole.record.force_residual_end < early.record.force_residual_end


def test_a_phase_of_full_time_that_gives_up_its_end_conditions_has_not_converged() -> None:
    """The moment alone soon raises the force residual again that the phase before brought down."""
    force = "{run: 'φ_fr|τ_frx(Γ) σ_fr(Γ)', until: {force_residual: 0.1}}"
    moment = "{run: 'φ_mr|τ_mrx(Γ) σ_mr(Γ)', until: {force_residual: 0.1, hold: 0}, limit: 10}"
    early, whole = (
        trial_loop(program("compare/cstar.yaml", f"program=[{force}, {moment}]", *more)).run(0, 5)
        for more in ((), ("program.1.full_time=true",))
    )
    assert early.record.outcome is Outcome.CONVERGED
    assert whole.record.outcome is not Outcome.CONVERGED
    assert whole.record.force_residual_end > 0.1 > early.record.force_residual_end
    assert whole.record.detail.count("‖ρ_f‖") == 1


# End conditions in words

BOUNDS = Until(force_residual=0.1, moment_residual=0.005, force_error=0.1)


def tick(force: float, moment: float, error: float = 0.0) -> Ticks:
    """A tick whose sensed residuals have these norms."""
    along = np.array([[0.6, 0.0, -0.8]])
    none, nothing = np.zeros((1, 0)), np.zeros((1, 1), dtype=bool)
    rest = np.zeros((1, 0, 0)), np.zeros((1, 0, 0, 1)), np.zeros((1, 0, 0)), np.zeros((1, 0, 3, 0))
    return Ticks(np.zeros((1, 1)), force * along, moment * along, np.array([error]), none, nothing, *rest)


@pytest.mark.parametrize(
    ("now", "said"),
    [
        (tick(0.01, 0.0056), "‖ρ_m‖ = 5.6 mm, not below 5 mm"),
        (tick(0.01, 0.005003), "‖ρ_m‖ = 5.003 mm, not below 5 mm"),
        (tick(0.25, 0.001), "‖ρ_f‖ = 0.25, not below 0.1"),
        (tick(0.25, 0.0056), "‖ρ_f‖ = 0.25, not below 0.1, and ‖ρ_m‖ = 5.6 mm, not below 5 mm"),
        (tick(0.01, 0.001, 0.3), "the largest error of a contact force = 0.3 N, not below 0.1 N"),
        (tick(0.01, 0.001, math.nan), ""),
        (tick(0.01, 0.001), ""),
    ],
)
def test_what_is_not_met_is_named_with_its_bound(now: Ticks, said: str) -> None:
    assert unmet(BOUNDS, now, []) == said
    assert is_low(BOUNDS, now).tolist() == [said == ""]


def test_what_is_not_waited_for_is_not_named() -> None:
    assert unmet(Until(moment_residual=0.005), tick(9.0, 0.001, 9.0), []) == ""


def test_contacts_that_do_not_touch_are_named_first() -> None:
    now = tick(0.25, 0.0)
    assert unmet(BOUNDS, now, ["finger-1"]) == "finger-1 does not touch, and ‖ρ_f‖ = 0.25, not below 0.1"
    assert unmet(Until(contact="all"), now, ["finger-1", "finger-3"]) == "finger-1 and finger-3 do not touch"
