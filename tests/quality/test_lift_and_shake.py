"""The simulator's verdict: a fair grasp is carried off, a slippery or a heavy object is not."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from graspdsl.compiler.program import program_of
from graspdsl.quality.carrying import balanced_forces
from graspdsl.quality.lift_and_shake import Handling, rise, sway
from graspdsl.trials.record import TrialRecord
from graspdsl.trials.setup import trial_loop

MAIN = Path(__file__).parents[2] / "specs" / "towel_roll_two_contacts.yaml"
EXPERIMENTS = MAIN.parent / "experiments"
FAIR = "trials.start={roll: 0.1, height: 0.10, standoff: 0.047}"


def graded(*overrides: str, spec: Path = MAIN) -> TrialRecord:
    """The record of a trial from a fair start, with grades."""
    settings = ("evaluate=[lift, shake]", FAIR, "scene.friction=0.5", *overrides)
    return trial_loop(program_of(spec.read_text("utf-8"), spec.name, settings)).run(0, 1).record


@pytest.mark.slow
@pytest.mark.parametrize("mount", ["gantry", "wam"])
def test_a_converged_grasp_is_kept(mount: str) -> None:
    record = graded(f"scene.mount={mount}")
    lift, shake = record.quality["lift"], record.quality["shake"]
    assert (lift["kept"], shake["kept"]) == (True, True), (lift, shake)
    assert lift["contacts"] == shake["contacts"] == 3
    assert lift["displacement"] < 0.005
    assert lift["squeeze"] == pytest.approx(Handling().squeeze, rel=0.1)
    assert lift["borne"]["value"] == pytest.approx(1.0, abs=0.01)


@pytest.mark.slow
@pytest.mark.parametrize("name", ["3_squirt_bottle", "4_detergent_bottle"])
@pytest.mark.parametrize("height", [0.08, 0.13])
def test_a_bottle_does_not_creep_in_the_hand(name: str, height: float) -> None:
    """Their centres of mass lie off the line between the contacts, so that friction bears moments too."""
    where = f"trials.start={{approach: side, roll: 0.5, height: {height}, standoff: 0.05}}"
    record = graded(where, "program.1.full_time=false", spec=EXPERIMENTS / f"{name}.yaml")
    assert record.quality["lift"]["displacement"] < 0.002, record.quality
    assert record.quality["shake"]["displacement"] < 0.010, record.quality
    assert record.quality["shake"]["kept"]


@pytest.mark.slow
@pytest.mark.parametrize("change", ["scene.friction=0.1", "scene.object={like: towel-roll, mass: 3.0}"])
def test_what_friction_cannot_carry_is_dropped(change: str) -> None:
    """Normal forces of 30 N in all carry no more than 3 N at a friction of 0.1, and 15 N at 0.5."""
    record = graded(change)
    assert not record.quality["lift"]["kept"]
    assert record.quality["lift"]["reason"]
    assert record.quality["shake"]["reason"] == "dropped before the shake"


def test_a_thumb_against_two_fingers_bears_what_both_do() -> None:
    points = np.array([[0.0, 0.05, 0.0], [-0.03, -0.05, 0.0], [0.03, -0.05, 0.0]])
    normals = np.array([[0.0, -1.0, 0.0], [0.0, 1.0, 0.0], [0.0, 1.0, 0.0]])
    np.testing.assert_allclose(balanced_forces(points, normals), [1.0, 0.5, 0.5], atol=1e-6)


def test_the_hand_starts_and_stops_at_rest() -> None:
    times = np.linspace(0.0, 1.0, 2001)
    way = np.array([rise(time) for time in times])
    speed = np.gradient(way, times)
    acceleration = np.gradient(speed, times)
    assert (way[0], way[-1]) == (0.0, 1.0)
    assert max(abs(speed[0]), abs(speed[-1])) < 1e-2
    assert np.abs(acceleration).max() == pytest.approx(5.774, rel=1e-2)  # 10/√3
    assert [sway(cycle, 2) for cycle in (0.0, 2.0, 5.0)] == [0.0, 0.0, 0.0]
    swung = np.array([sway(cycle, 2) for cycle in np.linspace(0.0, 2.0, 801)])
    assert np.abs(swung).max() == pytest.approx(1.0, abs=1e-3)


def test_the_acceleration_of_the_shake() -> None:
    """In the middle of a long shake it is that of a sine, A (2π f)²; where the shake swells it is more."""
    handling = Handling(amplitude=0.02, frequency=2.0)
    times = np.linspace(0.0, handling.cycles / 2.0, 4001)
    path = 0.02 * np.array([sway(2.0 * time, handling.cycles) for time in times])
    largest = np.abs(np.gradient(np.gradient(path, times), times)).max()
    assert handling.acceleration == pytest.approx(largest, rel=1e-3)
    assert handling.acceleration > 0.02 * (4.0 * np.pi) ** 2
