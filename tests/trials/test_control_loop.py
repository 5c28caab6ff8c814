"""A loop of one's own: tick by tick it is the trial that a world runs, by observations alone."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from graspdsl.compiler.program import Program, program_of
from graspdsl.spec.monitors import MONITORS
from graspdsl.spec.watching import Setting, Sight
from graspdsl.trials.control_loop import ControlLoop, Turn, sensed_truth
from graspdsl.trials.loop import TrialLoop
from graspdsl.trials.outcomes import Outcome
from graspdsl.trials.record import Trial
from graspdsl.trials.setup import world_of
from graspdsl.worlds.protocol import Command, Observation, Start, Truth, WitnessedWorld

SPECS = Path(__file__).parents[2] / "specs"
FLOATING = "compare/cstar.yaml"
TOWEL_ROLL = "towel_roll_two_contacts.yaml"


def program(name: str, *overrides: str) -> Program:
    """One of the example specs."""
    return program_of((SPECS / name).read_text("utf-8"), name, overrides)


@dataclass
class Recording:
    """A world of which is written down what is seen, what is true and what is commanded, tick by tick."""

    world: WitnessedWorld
    seen: list[Observation] = field(default_factory=list)
    true: list[Truth] = field(default_factory=list)
    commands: list[Command] = field(default_factory=list)

    def __post_init__(self) -> None:
        self.info = self.world.info

    def reset(self, start: Start, seed: int) -> Observation:
        """As of the world."""
        self.seen = [self.world.reset(start, seed)]
        return self.seen[0]

    def step(self, command: Command) -> Observation:
        """As of the world."""
        self.commands.append(command)
        self.seen.append(self.world.step(command))
        return self.seen[-1]

    def truth(self) -> Truth:
        """As of the world."""
        self.true.append(self.world.truth())
        return self.true[-1]

    def tare(self) -> None:
        """As of the world."""
        self.world.tare()

    def close(self) -> None:
        """As of the world."""
        self.world.close()


def recorded(made: Program, number: int, seed: int) -> tuple[Trial, Recording]:
    """A trial, and what there was to see."""
    recording = Recording(world_of(made))
    trial = TrialLoop(made, recording).run(number, seed)
    recording.true = recording.true[-len(recording.seen) :]  # the first is asked for as the trial begins, too
    return trial, recording


def turns(made: Program, recording: Recording, *, truths: bool) -> list[Turn]:
    """What a loop says of what there was to see, up to its ending."""
    loop, said = ControlLoop(made), list[Turn]()
    for seen, true in zip(recording.seen, recording.true, strict=True):
        said.append(loop.tick(seen, true if truths else None))
        if said[-1].ending is not None:
            break
    return said


def seen_by(count: int = 8, time: float = 0.0) -> Observation:
    """Contacts of no hand all over a ball."""
    inward = np.random.default_rng(5).normal(size=(count, 3))
    inward /= np.linalg.norm(inward, axis=-1, keepdims=True)
    nothing = np.zeros((count, 3, 0))
    return Observation(
        time=time,
        points=-0.05 * inward,
        normals=inward,
        forces=np.zeros((count, 3)),
        touching=np.ones(count, dtype=bool),
        joints=np.zeros(0),
        jacobian=nothing,
        angular_jacobian=nothing,
        orientations=np.zeros((count, 3)),
        centre_of_mass=np.zeros(3),
        weight=np.zeros(3),
    )


@pytest.mark.parametrize("path", ["spec.yaml", Path("spec.yaml")])
def test_a_path_is_no_program(path: Any) -> None:
    with pytest.raises(TypeError, match=r"not a \w*(str|Path): graspdsl.load reads a spec file"):
        ControlLoop(path)


# The meaning of a trial


@pytest.mark.parametrize(
    ("spec", "number", "outcome"),
    [
        (FLOATING, 0, Outcome.UNDONE),
        pytest.param("chapter/4_18_grasp.yaml", 0, Outcome.CONVERGED),
        pytest.param(TOWEL_ROLL, 0, Outcome.CONVERGED, marks=pytest.mark.slow),
        pytest.param("compare/probing.yaml", 0, Outcome.CONVERGED, marks=pytest.mark.slow),
        pytest.param("chapter/4_41_rotate_orientation.yaml", 0, Outcome.CONVERGED, marks=pytest.mark.slow),
    ],
)
def test_it_is_a_trial_to_the_last_bit(spec: str, number: int, outcome: Outcome) -> None:
    """Commands and ending are those of the trial; after it, the hand is to hold still."""
    made = program(spec)
    trial, recording = recorded(made, number, 12)
    said = turns(made, recording, truths=True)
    assert [turn.ending is None for turn in said] == [True] * len(recording.commands) + [False]
    for turn, command in zip(said, recording.commands, strict=False):
        assert turn.command.space == command.space
        np.testing.assert_array_equal(turn.command.displacement, command.displacement)
    ending = said[-1].ending
    assert ending is not None
    assert (ending.outcome, ending.detail) == (trial.record.outcome, trial.record.detail)
    assert ending.outcome is outcome
    assert said[-1].command.space == recording.commands[-1].space
    assert not said[-1].command.displacement.any()
    residuals = np.float32([turn.tick.force_residual for turn in said])
    np.testing.assert_array_equal(residuals, trial.trajectory["sensed_force_residual"])


def test_phases_are_told() -> None:
    """By number; a program that goes from one to the next within a tick tells the next."""
    both = "[{run: φ_fr|τ_frx(Γ) σ_fr(Γ), until: {force_residual: 9.0, hold: 0}, limit: 1.0}, {run: π_gx|Γ Γ, "
    both += "until: {force_residual: 1.0e-9, hold: 1.0}, limit: 1.0}]"
    loop = ControlLoop(program("compare/moment_subject_to_force.yaml", f"program={both}"))
    assert loop.tick(seen_by()).phase == 1


def test_time_is_that_of_the_observations() -> None:
    """However few there are, and whenever their clock was set."""
    made = program(FLOATING, "program.0.limit=2.0", "monitors.progress=off")
    for times, timed_out in (([100.0, 101.9, 101.99], False), ([100.0, 102.0], True), ([-3.0, -2.0, -1.0], True)):
        loop = ControlLoop(made)
        said = [loop.tick(seen_by(time=time)) for time in times]
        endings = [turn.ending.outcome for turn in said if turn.ending is not None]
        assert endings == ([Outcome.TIMEOUT] if timed_out else [])


def test_an_ending_is_for_good() -> None:
    loop = ControlLoop(program(FLOATING, "program.0.limit=1.0"))
    first, over, after = (loop.tick(seen_by(time=time)) for time in (0.0, 1.0, 1.5))
    assert first.ending is None
    assert first.command.displacement.any()
    assert over.ending is not None
    assert after.ending is over.ending
    for turn in (over, after):
        assert not turn.command.displacement.any()
        np.testing.assert_array_equal(turn.tick.force_residual, first.tick.force_residual)


# What a hand does not sense


@pytest.mark.slow
def test_without_a_truth_monitors_of_the_truth_are_silent() -> None:
    """The same trial, which a link on the object ends."""
    made = program(TOWEL_ROLL)
    trial, recording = recorded(made, 0, 11)
    assert trial.record.outcome == "link-collision"
    assert "link" in ControlLoop(made).silent_monitors
    assert turns(made, recording, truths=True)[-1].ending is not None
    assert turns(made, recording, truths=False)[-1].ending is None


def test_monitors_in_effect_act_or_are_silent() -> None:
    loop = ControlLoop(program(TOWEL_ROLL, "monitors.lost=off", "monitors.palm=off"))
    assert set(loop.monitors) == {"joint_limit", "progress"}
    assert set(loop.silent_monitors) == {"link", "table", "lean", "shift", "dragged"}


@pytest.mark.parametrize("key", MONITORS)
def test_monitors_of_the_truth_are_those_that_see_more_than_a_hand(key: str) -> None:
    """Links, lean and shift make no difference to the others; without these, they never speak."""
    kind = MONITORS[key]
    setting = Setting(
        ("a", "b"), ("p", "q"), "palm", -np.ones(2), np.ones(2), np.zeros((1, 2)), 0.05, probes=False, rate=50.0
    )

    def sight(time: float, links: Sequence[str], moved: float) -> Sight:
        return Sight(
            rows=np.array([0]),
            time=np.array([time]),
            grasp=(0, 1),
            touching=np.array([[True, False]]),
            touched=np.array([True]),
            joints=np.array([[1.0, 0.5]]),
            stopped=np.array([[True, False]]),
            links=[links],
            table_links=[links],
            lean=np.array([moved]),
            shift=np.array([moved]),
            force_residual=np.array([0.5]),
            moment_residual=np.array([0.01]),
            met=np.array([False]),
            awaits_residual=True,
            limit=30.0,
            waited_for=lambda _: "",
        )

    def speaks(links: Sequence[str], moved: float) -> bool:
        watch, times = kind(kind.default, setting), np.arange(1000) / 50.0
        return bool(np.any([watch.speaks(sight(float(time), links, moved)) for time in times]))

    assert speaks(("palm", "finger"), 3.0)
    assert speaks((), 0.0) is not kind.of_the_truth


def test_a_hand_knows_the_contacts_that_it_feels() -> None:
    seen = replace(seen_by(3), touching=np.array([True, False, True]), centre_of_mass=np.full(3, np.nan))
    truth = sensed_truth(seen)
    np.testing.assert_array_equal(np.isfinite(truth.points).all(axis=-1), seen.touching)
    np.testing.assert_array_equal(truth.points[seen.touching], seen.points[seen.touching])
    assert not truth.object_position.any()
    held = sensed_truth(replace(seen, centre_of_mass=np.array([0.1, 0.2, 0.3])))
    np.testing.assert_array_equal(held.object_position, [0.1, 0.2, 0.3])


# Observations that are none


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"points": np.full((8, 3), np.nan)}, "points"),
        ({"normals": np.full((8, 3), np.inf)}, "normals"),
        ({"points": np.zeros((2, 3))}, r"points of an observation must be \(8, 3\), not \(2, 3\)"),
        ({"joints": np.zeros(4)}, r"joints of an observation must be \(0,\), not \(4,\)"),
        ({"time": 0.0}, "comes after"),
        ({"time": -1.0}, "comes after"),
        ({"time": np.nan}, "comes after"),
        ({"time": np.inf}, "comes after"),
    ],
)
def test_what_is_no_observation_is_no_tick(changes: dict[str, object], said: str) -> None:
    made = program(FLOATING)
    loop, other = ControlLoop(made), ControlLoop(made)
    for each in (loop, other):
        each.tick(seen_by(time=0.0))
    with pytest.raises(ValueError, match=said):
        loop.tick(replace(seen_by(time=0.02), **changes))
    after, meant = (each.tick(seen_by(time=0.02)) for each in (loop, other))
    np.testing.assert_array_equal(after.command.displacement, meant.command.displacement)


def test_gravity_needs_to_know_where_the_object_is() -> None:
    made = program("chapter/4_40_rotate.yaml")
    ControlLoop(made).tick(seen_by_hand(made))
    with pytest.raises(ValueError, match="centre_of_mass of the observation hold"):
        ControlLoop(made).tick(replace(seen_by_hand(made), centre_of_mass=np.full(3, np.nan)))


# Rates

RATES = pytest.mark.parametrize(("rate", "share"), [(None, 1.0), (50.0, 1.0), (100.0, 0.5), (250.0, 0.2), (25.0, 1.0)])


def seen_by_hand(made: Program) -> Observation:
    """Contacts of a program's hand all over a ball; the joints move them somehow."""
    count, joints = len(made.robot.contacts), len(made.robot.joints)
    jacobian = np.random.default_rng(6).normal(scale=0.1, size=(count, 3, joints))
    return replace(seen_by(count), joints=np.ones(joints), jacobian=jacobian, angular_jacobian=jacobian)


@RATES
def test_a_faster_loop_moves_joints_less_in_a_tick_and_a_slower_one_no_more(rate: float | None, share: float) -> None:
    made = program(TOWEL_ROLL)
    usual = ControlLoop(made).tick(seen_by_hand(made)).command
    assert usual.space == "q"
    found = ControlLoop(made, rate).tick(seen_by_hand(made)).command
    np.testing.assert_allclose(found.displacement, share * usual.displacement, rtol=1e-15)


def test_contacts_are_displaced_by_as_much_at_any_rate() -> None:
    made = program("compare/probing.yaml", "program.0.until={contact: all, hold: 0}")
    usual, found = (ControlLoop(made, rate).tick(seen_by_hand(made)) for rate in (None, 100.0))
    assert (found.phase, found.command.space) == (1, "x")
    np.testing.assert_array_equal(found.command.displacement, usual.command.displacement)
