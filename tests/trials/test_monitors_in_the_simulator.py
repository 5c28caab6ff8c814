"""Every way a trial can end, brought about in the simulator by a spec; and what becomes of it with that monitor off."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest

from graspdsl.compiler.program import program_of
from graspdsl.quality.grade import CRASHED
from graspdsl.trials.loop import NoFeasibleStartError, TrialLoop
from graspdsl.trials.outcomes import OUTCOMES, Outcome
from graspdsl.trials.record import RejectedStart, TrialRecord
from graspdsl.trials.setup import trial_loop, world_of
from graspdsl.worlds.bullet.stage import BulletStage
from graspdsl.worlds.bullet.stages import BulletEngine
from graspdsl.worlds.kind import WorldSettings
from graspdsl.worlds.protocol import Command, Observation
from graspdsl.worlds.rigid.world import RigidWorld

pytestmark = pytest.mark.slow

SPECS = Path(__file__).parents[2] / "specs"
MAIN = "towel_roll_two_contacts.yaml"
SLIDE = "chapter/4_24_slide.yaml"
ROTATE = "chapter/4_40_rotate.yaml"
FAIR_START = "trials.start={roll: 0.4, height: 0.10, standoff: 0.047}"


def run(spec: str, *overrides: str) -> TrialRecord:
    """The record of one trial."""
    return trial_loop(program_of((SPECS / spec).read_text("utf-8"), spec, ("evaluate=[]", *overrides))).run(0, 5).record


def joints(names: str, reference: str, hold: float) -> tuple[str, ...]:
    """Instead of sliding, some joints go to where they are told, until all contacts have touched for a while."""
    formula = "program.1.run=φ_k|τ_k(Γ_k) σ_k(Γ_k) (k_ref)"
    until = f"program.1.until={{contact: all, hold: {hold}}}"
    return (f"resources.Γ_k={names}", f"parameters.k_ref={reference}", formula, until)


@dataclass(frozen=True)
class Ending:
    """A spec that ends in an outcome, words of its detail, and where it ends when monitors are set otherwise."""

    about: str
    outcome: Outcome
    detail: str
    spec: str
    settings: tuple[str, ...]
    otherwise: tuple[tuple[str, Outcome], ...]

    def __str__(self) -> str:
        return self.about.replace(" ", "-")


# Positions sent around to the far side of the roll draw the palm, and then the fingers, onto its near side.
AROUND = ("parameters.x_ref=[0.05, -0.03, 0.1, 0.05, 0.03, 0.1]",)
# The hand carries off a light roll that its fingers hold fast.
LIGHT = ("scene.object={like: towel-roll, mass: 0.1}", "scene.friction=1.0")
UNREACHED = ("program.1.run=π_close|Γ Γ", "program.1.until={force_residual: 1e-4, hold: 1.0}", FAIR_START)

ENDINGS = (
    Ending(
        "the palm on the roll",
        OUTCOMES["palm-collision"],
        "the palm",
        SLIDE,
        AROUND,
        (
            ("monitors={palm: off}", OUTCOMES["link-collision"]),
            ("monitors={palm: off, link: off}", Outcome.CONVERGED),
        ),
    ),
    Ending(
        "fingers flat on the roll",
        OUTCOMES["link-collision"],
        "distal-1, distal-2, distal-3 touched the object for 0.5 s",
        SLIDE,
        (*AROUND, "monitors.palm=off"),
        (("monitors.link=off", Outcome.CONVERGED),),
    ),
    Ending(
        "the palm on the table",
        OUTCOMES["table-contact"],
        "palm touched the table",
        SLIDE,
        ("parameters.x_ref=[0.0, -0.05, -0.05, 0.0, 0.05, -0.05]",),
        (("monitors.table=off", Outcome.CONVERGED),),
    ),
    Ending(
        "the hand withdraws",
        OUTCOMES["contact-lost"],
        "finger-3 lost the object for 2 s",
        SLIDE,
        (*joints("wrist-z", "-0.1", 3.0), "program.1.limit=5"),
        (("monitors.lost=off", Outcome.TIMEOUT), ("monitors.lost=stop", OUTCOMES["contact-lost"])),
    ),
    Ending(
        "no time to touch",
        OUTCOMES["contact-lost"],
        "finger-3, finger-1, finger-2 made no contact within 0.1 s",
        MAIN,
        (FAIR_START, "program.0.limit=0.1"),
        (("monitors.lost=off", Outcome.TIMEOUT),),
    ),
    Ending(
        "a rod pulled over as the hand withdraws",
        Outcome.TOPPLED,
        "the object leant",
        SLIDE,
        (
            *joints("wrist-z", "-0.1", 5.0),
            "scene.object={cylinder: {diameter: 0.02, height: 0.2}}",
            "trials.start={height: 0.1, standoff: 0.06}",
        ),
        (("monitors.lean=off", OUTCOMES["palm-collision"]),),
    ),
    Ending(
        "a light roll carried off a little",
        OUTCOMES["dragged"],
        "dragged",
        SLIDE,
        (*joints("wrist-y", "0.05", 2.0), *LIGHT),
        (("monitors.dragged=off", Outcome.CONVERGED), ("monitors.shift=0.02", OUTCOMES["diverged"])),
    ),
    Ending(
        "a light roll carried off",
        OUTCOMES["diverged"],
        "moved 100 mm",
        SLIDE,
        (*joints("wrist-y", "0.3", 10.0), *LIGHT),
        (("monitors.shift=off", OUTCOMES["dragged"]),),
    ),
    Ending(
        "fingers that open as far as they go",
        OUTCOMES["joint-limit"],
        "base-1 at a limit for 2 s",
        SLIDE,
        (*joints("base-1", "-0.5", 1.0), "monitors.lost=off", "program.1.limit=10"),
        (("monitors.joint_limit=off", Outcome.TIMEOUT), ("monitors.joint_limit=stop", OUTCOMES["joint-limit"])),
    ),
    Ending(
        "a joint at its limit when time is up",
        OUTCOMES["joint-limit"],
        "base-1 at a limit",
        SLIDE,
        (*joints("base-1", "-0.5", 1.0), "monitors={lost: off, joint_limit: 60}", "program.1.limit=5"),
        (("monitors.joint_limit=off", Outcome.TIMEOUT),),
    ),
    Ending(
        "a residual that the close does not lower",
        OUTCOMES["local-minimum"],
        "the residual stopped falling: ‖ρ_f‖ = ",
        MAIN,
        (*UNREACHED, "monitors.progress={window: 1.0}", "program.1.limit=6"),
        (("monitors.progress=off", Outcome.TIMEOUT), ("monitors.progress={window: 4.0}", Outcome.TIMEOUT)),
    ),
    Ending(
        "too little time",
        Outcome.TIMEOUT,
        "not converged within 0.3 s: ",
        MAIN,
        (FAIR_START, "program.1.limit=0.3"),
        (),
    ),
    Ending(
        "too little time to hold",
        Outcome.TIMEOUT,
        "not converged within 1 s: the end conditions held for 1.0 s of 2 s",
        MAIN,
        (FAIR_START, "program.1={run: π_close|Γ Γ, until: {contact: all, hold: 2}, limit: 1}"),
        (),
    ),
    Ending(
        "a bound on the moment alone is missed",
        OUTCOMES["local-minimum"],
        "the residual stopped falling: ‖ρ_m‖ = ",
        MAIN,
        (
            *UNREACHED,
            "program.1.until={force_residual: 10, moment_residual: 1e-4, hold: 1.0}",
            "monitors.progress={window: 1.0}",
        ),
        (),
    ),
    Ending(
        "a start in the table",
        Outcome.INFEASIBLE_START,
        "without meeting the object",
        MAIN,
        ("trials.start={height: -0.05}",),
        (),
    ),
)
WAYS = [(ending, change, outcome) for ending in ENDINGS for change, outcome in ending.otherwise]


@pytest.mark.parametrize("ending", ENDINGS, ids=str)
def test_an_outcome_is_brought_about(ending: Ending) -> None:
    record = run(ending.spec, *ending.settings)
    assert (record.outcome, ending.detail in record.detail) == (ending.outcome, True), record.detail
    assert record.ticks_to_converge is None


@pytest.mark.parametrize(("ending", "change", "outcome"), WAYS, ids=[f"{e}-{c}" for e, c, _ in WAYS])
def test_a_monitor_set_otherwise_ends_the_trial_otherwise(ending: Ending, change: str, outcome: Outcome) -> None:
    record = run(ending.spec, *ending.settings, change)
    assert record.outcome is outcome, record.detail


def test_a_monitor_of_a_time_waits_for_it() -> None:
    """With a longer time for the same cause the trial ends later by what was added."""
    settings = (*AROUND, "monitors.palm=off")
    short, long = (run(SLIDE, *settings, f"monitors.link={time}") for time in (0.2, 0.6))
    assert short.outcome is long.outcome is OUTCOMES["link-collision"]
    assert long.world_s - short.world_s == pytest.approx(0.4, abs=0.021)  # a tick either way


def test_a_held_ball_meets_the_wrists_limit() -> None:
    """Its end conditions hold all the while, so that only the end of time shows what was in the way."""
    far = "parameters.x_ref=[-1.5, -0.05, 0.05, -1.5, 0.05, 0.05]"
    until = "program.1.until={contact: all, hold: 40}"
    record = run(ROTATE, "program.1.run=π_s|Γ Γ (x_ref)", far, until, "program.1.limit=30")
    assert record.outcome is OUTCOMES["joint-limit"], record.detail
    assert "wrist-z" in record.detail


def test_every_outcome_is_brought_about() -> None:
    elsewhere = {Outcome.CRASHED, Outcome.CONVERGED, Outcome.UNDONE}  # below, in test_loop.py and in test_course.py
    assert {ending.outcome for ending in ENDINGS} | elsewhere == set(OUTCOMES.values())


# Starts


def test_a_start_that_cannot_be_is_drawn_once_where_every_draw_is_the_same() -> None:
    record = run(MAIN, "trials.start={height: -0.05}")
    assert len(record.rejected) == 1
    assert record.detail.startswith("the start is not feasible: ")


def test_draws_that_all_fail_are_told_by_their_commonest_reason() -> None:
    program = program_of((SPECS / MAIN).read_text("utf-8"), MAIN, ("trials.start={height: {uniform: [-0.06, -0.05]}}",))
    record = TrialLoop(program, world_of(program), most_draws=8).run(0, 5).record
    assert (record.outcome, len(record.rejected)) == (Outcome.INFEASIBLE_START, 8)
    assert record.detail == "no start in 8 draws was feasible: finger-1 closes without meeting the object"
    several = NoFeasibleStartError([RejectedStart({}, reason) for reason in ["it rains"] * 3 + ["it snows"] * 5])
    assert str(several) == "no start in 8 draws was feasible: it snows (5 times)"


# A crash


class Struck(RigidWorld):
    """A world in which a force without measure strikes a finger that grasps, so that the engine's numbers end."""

    def step(self, command: Command) -> Observation:
        """One tick, with the blow before it once every fingertip touches."""
        if not np.isfinite(self.truth().points).all():
            return super().step(command)
        stage = self.stage
        assert isinstance(stage, BulletStage)
        stage.engine.applyExternalForce(
            stage.hand.body,
            stage.hand.tips[0].link,
            [float(np.finfo(float).max), 0.0, 0.0],
            [0.0, 0.0, 0.0],
            stage.engine.LINK_FRAME,
            physicsClientId=stage.client,
        )
        return super().step(command)


def test_a_simulation_without_numbers_has_crashed() -> None:
    """In contact: its grades say so, and not that nothing touched."""
    grades = "evaluate=[force-closure, ferrari-canny, lift, shake]"
    program = program_of((SPECS / MAIN).read_text("utf-8"), MAIN, (FAIR_START, grades))
    world = Struck(BulletEngine(), WorldSettings(program.robot, program.body, 0.4))
    record = TrialLoop(program, world).run(0, 5).record
    assert record.outcome is Outcome.CRASHED
    assert "number" in record.detail
    assert record.samples > 0
    measures = record.quality["ferrari-canny"]
    graded = [record.quality["force-closure"], measures["epsilon"], measures["volume"], record.quality["lift"]]
    assert {grade["reason"] for grade in (*graded, record.quality["shake"])} == {CRASHED}


def test_a_grasp_that_holds_its_end_conditions_has_not_stalled() -> None:
    """However long they have to hold: a residual that is low enough need not fall any further."""
    found = run(MAIN, FAIR_START, "program.1.until.hold=15.0", "program.1.limit=60.0")
    assert (found.outcome, found.detail) == (Outcome.CONVERGED, "")
