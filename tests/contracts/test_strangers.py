"""What a stranger adds does what it is for: against closed forms, and in trials of floating contacts."""

from __future__ import annotations

import math
from pathlib import Path

import graspdsl_stranger
import numpy as np
import pytest
import yaml
from compiler.specs import floating, spec
from graspdsl_stranger.grade import IsotropyGrade
from graspdsl_stranger.monitor import ReboundMonitor
from graspdsl_stranger.potential import BEND, Centring
from quality.grasps import antipodal, ring
from spec.test_watching import setting, sight

from graspdsl.arrays import Array
from graspdsl.compiler.explain import explained
from graspdsl.compiler.program import Program, examine
from graspdsl.hands.descriptions import robot
from graspdsl.quality.grade import Grasp
from graspdsl.trials.outcomes import Outcome
from graspdsl.trials.setup import trial_loop

THREE = "{γ1, γ2, γ3}"
FILE = Path(graspdsl_stranger.__file__).with_name("controllers.yaml")
CONTROLLERS = {head: entry["is"] for head, entry in yaml.safe_load(FILE.read_text("utf-8"))["controllers"].items()}


def program(formula: str) -> Program:
    """Three floating contacts on a towel roll, the stranger's controllers among the spec's own."""
    until = "force_residual: 0.02, moment_residual: 0.002, hold: 4"
    text = floating(formula, scene="object: towel-roll", controllers=CONTROLLERS, until=until)
    examination = examine(text, "test.yaml")
    assert examination.diagnostics == ()
    assert examination.program is not None
    return examination.program


def offsets(formula: str, trials: int = 4) -> Array:
    """How far the contacts' centroid is from the object's centre of mass [m] at the end of each trial."""
    loop, found = trial_loop(program(formula)), []
    for number in range(trials):
        result = loop.run(number, 3)
        assert result.record.outcome is Outcome.CONVERGED
        found.append(np.linalg.norm(result.trajectory["points"][-1, :3].mean(axis=0)))
    return np.array(found)


@pytest.mark.slow
def test_of_the_grasps_on_a_towel_roll_its_controller_finds_the_middle_one() -> None:
    """Force and moment residual leave the height open; the lowest level of the stranger's decides it."""
    usual, centred = (offsets(f"{name}|{THREE} {THREE}") for name in ("π_gx", "π_gc"))
    assert np.median(usual) > 0.01
    assert centred.max() < 1e-3


def test_it_is_explained_with_its_sources() -> None:
    text = explained(program(f"π_gc|{THREE} {THREE}"))[0].text()
    assert f"{Centring.symbol}  {Centring.about} ({Centring.equation})" in text
    assert "τ_cx({γ1, γ2, γ3})  net lever of the contacts by contact displacements → x (Roa and Suárez 2015)" in text


def test_what_is_known_of_a_held_object_alone_is_not_sensed_of_a_free_one() -> None:
    text = spec(f"φ_p|τ_p({THREE}) σ_p({THREE}) (π_c|{THREE} {THREE})", controllers=CONTROLLERS)
    [found] = examine(text, "test.yaml").diagnostics
    assert found.code == "not-sensed"
    assert found.message.startswith("σ_c cannot be sensed")
    held = spec(
        f"φ_p|τ_p({THREE}) σ_p({THREE}) (π_c|{THREE} {THREE})",
        controllers=CONTROLLERS,
        scene="world: bullet, object: {like: towel-roll, held: true}",
    )
    assert [fault.code for fault in examine(held, "test.yaml").diagnostics if fault.code == "not-sensed"] == []


@pytest.mark.parametrize("length", [0.0, BEND, 2.0 * BEND])
def test_its_potential_is_a_pseudo_huber_function(length: float) -> None:
    """In closed form: a hyperbola, above its asymptote 2b (|e| − b) and no higher than eᵀe."""
    error = length * np.array([0.6, 0.0, -0.8])
    value = Centring().value(error)
    assert value == pytest.approx(2.0 * BEND * (np.hypot(length, BEND) - BEND))
    assert 2.0 * BEND * (length - BEND) < value <= length**2


@pytest.mark.parametrize(
    ("points", "index"),
    [
        (np.concatenate([np.eye(3), -np.eye(3)]), math.sqrt(2 / 3)),  # forces 6 I, moments (6 − 2) I
        (np.array([[1, 1, 1], [1, -1, -1], [-1, 1, -1], [-1, -1, 1]]), math.sqrt(2 / 3)),  # 4 I and (4 − 4/3) I
        (ring(3)[0], math.sqrt(1 / 2)),  # 3 I and, of levers in a plane, 3 I − 3/2 of that plane
        (antipodal()[0], 0.0),
    ],
)
def test_its_grade_is_that_of_grasps_in_closed_form(points: Array, index: float) -> None:
    length = float(np.linalg.norm(points[0]))
    found = IsotropyGrade().of(
        Grasp(robot("barrett", "gantry"), 0.5, length, points.astype(float), -points.astype(float))
    )
    assert found["index"]["value"] == pytest.approx(index)
    assert bool(found["index"]["reason"]) is (index == 0.0)


def test_its_monitor_speaks_of_a_residual_that_rises_again() -> None:
    monitor = ReboundMonitor(ReboundMonitor.default, setting())
    course = {0.08: False, 0.05: False, 0.01: False, 0.03: False, 0.041: True, 0.02: False}
    spoken = {value: bool(monitor.speaks(sight(moment_residual=value))[0]) for value in course}
    assert spoken == course
    assert monitor.detail(sight(moment_residual=0.041), 0) == "the moment residual rose by 31 mm"
