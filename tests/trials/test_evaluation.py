"""Grades of final grasps: of the contacts that touch, and without a trace in a trial's other numbers."""

from __future__ import annotations

import dataclasses
import json
from pathlib import Path

import numpy as np
import pytest

from graspdsl.compiler.program import Program, program_of
from graspdsl.trials.outcomes import OUTCOMES
from graspdsl.trials.record import Trial
from graspdsl.trials.setup import trial_loop

SPECS = Path(__file__).parents[2] / "specs"
MAIN, FLOATING = "towel_roll_two_contacts.yaml", "chapter/4_18_grasp.yaml"
THEORY = "evaluate=[force-closure, ferrari-canny]"


def program(spec: str, *overrides: str) -> Program:
    """A spec of the project with overrides."""
    return program_of((SPECS / spec).read_text("utf-8"), spec, overrides)


def run(spec: str, *overrides: str) -> Trial:
    """One trial."""
    return trial_loop(program(spec, *overrides)).run(1, 5)


def ungraded(trial: Trial) -> tuple[str, dict[str, bytes]]:
    """All of a trial but its grades, the identity they have a part in and the computer's time."""
    record = dataclasses.replace(trial.record, wall_s=0.0, quality={}, identity="")
    return repr(record.as_dict()), {name: rows.tobytes() for name, rows in trial.trajectory.items()}


def test_floating_contacts_are_judged_with_friction() -> None:
    grades = run(FLOATING, THEORY).record.quality
    assert grades["force-closure"]["closed"]
    assert grades["force-closure"]["model"] == "hard point contact, μ = 0.4"
    without = run(FLOATING, THEORY, "scene.friction=0.0").record.quality
    assert not without["force-closure"]["closed"]
    assert without["ferrari-canny"]["epsilon"]["value"] == 0.0
    assert without["force-closure"]["reason"] == without["ferrari-canny"]["epsilon"]["reason"] != ""


def test_grades_are_plain_data() -> None:
    grades = run(FLOATING, THEORY).record.quality
    assert json.loads(json.dumps(grades, allow_nan=False)) == grades


@pytest.mark.slow
@pytest.mark.parametrize(("spec", "grades"), [(FLOATING, THEORY), (MAIN, "evaluate=[lift, shake]")])
def test_grading_changes_nothing_else(spec: str, grades: str) -> None:
    plain, graded = run(spec), run(spec, grades)
    assert ungraded(plain) == ungraded(graded)
    assert plain.record.quality == {}
    assert plain.record.identity != graded.record.identity


def test_a_trial_without_contacts() -> None:
    record = run(MAIN, THEORY, "program.0.limit=0.02").record
    assert record.outcome is OUTCOMES["contact-lost"]
    assert record.quality["force-closure"]["reason"] == "no contacts"
    assert record.quality["ferrari-canny"]["epsilon"] == {"value": None, "reason": "no contacts"}


@pytest.mark.slow
def test_the_grasp_is_judged_at_its_last_tick() -> None:
    trial = run(MAIN, THEORY, "trials.start.roll=0.4", "trials.start.height=0.1", "trials.start.standoff=0.047")
    points, position = trial.trajectory["points"][-1], trial.trajectory["object_position"][-1]
    levers = np.linalg.norm(points - position, axis=1)
    assert trial.record.quality["force-closure"]["contacts"] == 3
    assert trial.record.quality["ferrari-canny"]["length"] == pytest.approx(float(levers.max()), rel=1e-5)
