"""Grades of final grasps: of the contacts that touch, and without a trace in a trial's other numbers."""

from __future__ import annotations

import dataclasses
import json
import math
from pathlib import Path

import numpy as np
import pytest

import graspdsl as g
from graspdsl.compiler.program import Program, program_of
from graspdsl.trials.outcomes import OUTCOMES, Outcome
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
    normals = trial.trajectory["normals"][-1].astype(float)
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    found = trial.record.quality["ferrari-canny"]
    again = g.ferrari_canny(points, normals, 0.4, about=position, length=found["length"])
    assert trial.record.quality["force-closure"]["contacts"] == 3
    assert found["epsilon"]["value"] == pytest.approx(again.epsilon.value, rel=1e-3)


def test_moments_are_over_the_radius_of_gyration_of_the_object_or_a_length() -> None:
    """Of an ellipsoid of half axes a, b, c: tr I = (2/5) m (a² + b² + c²)."""
    half = np.array([0.04, 0.06, 0.09])
    shape = f"scene.object={{ellipsoid: {{size: {(2 * half).tolist()}}}}}"
    gyration = math.sqrt(2.0 / 15.0 * (half**2).sum())
    found = run(FLOATING, THEORY, shape).record.quality["ferrari-canny"]
    assert found["length"] == pytest.approx(gyration, rel=1e-12)
    assert found["scale"] == "the object's radius of gyration"
    heavier = run(FLOATING, THEORY, shape.replace("}}", "}, mass: 2.0}"))
    assert heavier.record.quality["ferrari-canny"] == found
    given = run(FLOATING, THEORY, shape, "grading.torque_scale=0.03").record.quality["ferrari-canny"]
    assert (given["length"], given["scale"]) == (0.03, "as the spec gives it")
    assert given["epsilon"]["value"] > found["epsilon"]["value"]


@pytest.mark.parametrize("scale", [1e-4, 10.0])
def test_no_torque_scale_that_can_be_given_changes_whether_a_grasp_is_closed(scale: float) -> None:
    wanted, found = (run(FLOATING, THEORY, *given).record.quality for given in ((), (f"grading.torque_scale={scale}",)))
    assert found["force-closure"]["closed"] is wanted["force-closure"]["closed"] is True
    assert found["force-closure"]["margin"]["value"] == pytest.approx(wanted["force-closure"]["margin"]["value"])
    assert found["ferrari-canny"]["epsilon"]["value"] > 0.0


@pytest.mark.parametrize(
    ("gamma", "grading", "model", "closed"),
    [
        ("{γ1, γ2}", {}, "soft finger contact, μ = 0.4, μ_t = 0.652 mm", True),
        ("{γ1, γ2}", {"contact": "hard"}, "hard point contact, μ = 0.4", False),
        ("{γ1, γ2, γ3}", {}, "hard point contact, μ = 0.4", True),
        ("{γ1, <γ2, γ3>}", {}, "hard point contact, μ = 0.4", True),  # three that touch
        ("{γ1, γ2, γ3}", {"torsion": 0.002}, "soft finger contact, μ = 0.4, μ_t = 2 mm", True),
        ("{γ1, γ2, γ3}", {"contact": "frictionless"}, "frictionless point contact", False),
    ],
)
def test_two_contacts_are_soft_fingers_and_more_are_hard(
    gamma: str, grading: dict[str, object], model: str, closed: bool
) -> None:
    set_grading = [f"grading.{key}={value}" for key, value in grading.items()]
    trial = run(FLOATING, THEORY, f"resources.Γ='{gamma}'", *set_grading)
    assert trial.record.outcome is Outcome.CONVERGED
    found = trial.record.quality["force-closure"]
    assert (found["model"], found["closed"]) == (model, closed)
