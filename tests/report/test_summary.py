"""The numbers of a report, from records made by hand."""

from __future__ import annotations

import json
import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from stored_runs import lose_trajectory
from trials.whole import whole_rows

from graspdsl.cli.tables import summary_text
from graspdsl.report.evidence import evidence_of
from graspdsl.report.page import notes
from graspdsl.report.statistics import wilson
from graspdsl.report.summary import plain, repeating, summarised
from graspdsl.trials.outcomes import OUTCOMES, Outcome
from graspdsl.trials.record import RejectedStart, Trial, TrialRecord
from graspdsl.trials.store import Manifest, RunFolder

SPEC = Path(__file__).parents[2] / "specs" / "towel_roll_two_contacts.yaml"

Build = Callable[..., RunFolder]
REJECTED = tuple(RejectedStart({}, reason) for reason in ("it rains", "it snows", "it rains", "it rains"))


def _numbers(folder: RunFolder) -> Any:
    """The numbers of a run as JSON has them."""
    return plain(summarised(evidence_of(folder)))


def _record(number: int, **values: Any) -> TrialRecord:
    nothing = {name: math.nan for name, kind in TrialRecord.__annotations__.items() if kind == "float"}
    measured = {
        "identity": "x",
        "outcome": Outcome.CONVERGED,
        "detail": "",
        "start": {},
        "rejected": (),
        "contact_forces": (0.5, 0.4),
        "ticks": 10,
        "ticks_to_converge": None,
        "samples": 11,
        "point_error": (math.nan, math.nan),
        "normal_error": (math.nan, math.nan),
        "world_s": 1.0,
    }
    touching = (values.get("outcome") is not OUTCOMES["contact-lost"],) * 2
    return TrialRecord(**{**nothing, **measured, "number": number, "touching": touching, **values})


@pytest.fixture
def build(tmp_path: Path) -> Build:
    """Makes the folder of a run with these records."""

    def built(*records: TrialRecord, asked: int = 5, overrides: tuple[str, ...] = ()) -> RunFolder:
        manifest = Manifest("a-run", "spec.yaml", overrides, 7, asked, {"graspdsl": "0"}, 2.5)
        folder = RunFolder.create(tmp_path / "the run", manifest, SPEC.read_text(encoding="utf-8"))
        for record in records:
            folder.add(Trial(record, whole_rows(1)).packed())
        return folder

    return built


def test_a_run_without_trials(build: Build) -> None:
    numbers = _numbers(build())
    assert json.loads(json.dumps(numbers, allow_nan=False))["trials"] == {"asked": 5, "finished": 0, "different": 0}
    assert (numbers["outcomes"], numbers["modes"], numbers["records"]) == ({}, [], [])
    assert numbers["converged"]["share"] is None
    assert numbers["residuals"]["force"] == {
        "start": None,
        "end": None,
        "end_in_contact": None,
        "squared": {"start": None, "end": None, "end_in_contact": None},
    }
    assert numbers["ticks_to_converge"] == {"median": None, "p90": None}


def test_what_was_not_measured_is_left_out_of_medians_and_modes(build: Build) -> None:
    lost = _record(1, outcome=Outcome.CRASHED, contact_forces=(), rejected=REJECTED)
    ends = [
        _record(number, orientation_end=1.5, force_residual_end=residual, moment_residual_end=0.002)
        for number, residual in ((0, 0.02), (2, 0.08), (3, 0.03))
    ]
    numbers = _numbers(build(lost, *ends))
    assert "NaN" not in json.dumps(numbers, allow_nan=False)
    assert numbers["orientation"]["end"] == [1.5, None, 1.5, 1.5]
    assert numbers["residuals"]["force"]["end"] == 0.03
    assert numbers["outcomes"] == {"converged": 3, "crashed": 1}
    (mode,) = numbers["modes"]
    assert (mode["share"], mode["trials"], mode["force_residual"]) == (1.0, [0, 2, 3], 0.03)
    assert mode["centre"] == pytest.approx(1.5, abs=0.01)
    assert numbers["starts"]["rejected"] == {"it rains": 3, "it snows": 1}
    assert numbers["records"][1]["point_error"] == [None, None]


def test_modes_are_of_trials_whose_contacts_touched_at_the_end(build: Build) -> None:
    """A contact that was lost, or a trajectory that is, leaves a trial out of modes and of what is in contact."""
    lost = _record(2, outcome=OUTCOMES["contact-lost"], orientation_end=0.3, force_residual_end=0.9)
    folder = build(*(_record(number, orientation_end=1.5, force_residual_end=0.03) for number in (0, 1, 3)), lost)
    lose_trajectory(folder, 3)
    numbers = _numbers(folder)
    assert numbers["in_contact"]["end"] == [True, True, False, None]
    assert [mode["trials"] for mode in numbers["modes"]] == [[0, 1]]
    assert numbers["residuals"]["force"]["end_in_contact"] == 0.03
    assert numbers["residuals"]["force"]["squared"]["end_in_contact"] == pytest.approx(0.03**2)


def test_trials_that_a_monitor_stopped_are_in_no_mode(build: Build) -> None:
    stopped = [
        _record(number, outcome=OUTCOMES["palm-collision"], orientation_end=0.4, force_residual_end=0.9)
        for number in (1, 4, 5)
    ]
    lost = _record(6, outcome=OUTCOMES["contact-lost"], orientation_end=0.3)
    late = _record(7, outcome=Outcome.TIMEOUT, orientation_end=1.5, force_residual_end=0.03)
    settled = [_record(number, orientation_end=1.5, force_residual_end=0.03) for number in (0, 2, 3)]
    numbers = _numbers(build(*settled, *stopped, lost, late, asked=8))
    assert [(mode["trials"], mode["share"], mode["of"]) for mode in numbers["modes"]] == [([0, 2, 3, 7], 1.0, 4)]
    assert numbers["modes"][0]["force_residual"] == 0.03
    assert numbers["stopped"] == {"share": 3 / 7, "of": 7, "interval": list(wilson(3, 7)), "trials": [1, 4, 5]}


def test_records_stand_by_number_whatever_the_order_they_came_in(build: Build) -> None:
    numbers = _numbers(build(*(_record(number, orientation_start=number / 10) for number in (3, 0, 2, 1))))
    assert numbers["orientation"]["start"] == [0.0, 0.1, 0.2, 0.3]


def test_ticks_and_forces_are_of_converged_trials(build: Build) -> None:
    slow = [_record(number, ticks_to_converge=10 * number) for number in range(11)]
    lost = _record(11, outcome=OUTCOMES["contact-lost"], contact_forces=(9.0, 0.0))
    numbers = _numbers(build(*slow, lost, asked=12))
    assert numbers["ticks_to_converge"] == {"median": 50.0, "p90": 90.0}
    assert numbers["contact_force"] == {"median": 0.45, "least": 0.4, "largest": 0.5}
    assert numbers["converged"]["share"] == 11 / 12


@pytest.mark.parametrize(
    ("start", "different", "said"),
    [
        ("{roll: 0.3}", 1, "Nothing differs between these 4 trials"),
        ("{roll: {choice: [0.1, 0.2]}}", 2, "Only 2 of these 4 trials can differ"),
        ("{roll: {uniform: [-1, 1]}}", 4, None),
    ],
)
def test_trials_that_repeat_others_are_told_beside_the_share(
    start: str, different: int, said: str | None, build: Build
) -> None:
    """On a terminal and on the page."""
    folder = build(*(_record(number) for number in range(4)), overrides=(f"trials.start={start}",))
    evidence = evidence_of(folder)
    summary = summarised(evidence)
    assert summary.different == different
    for text in (" ".join(summary_text(summary).split()), " ".join(notes(evidence, summary))):
        assert said in text if said else "differ" not in text


def test_what_converged_means_follows_the_settings(build: Build) -> None:
    numbers = _numbers(build(overrides=("program.1.until={force_residual: 0.2}",)))
    assert numbers["converged"]["means"] == {
        "contact": None,
        "force_residual": 0.2,
        "moment_residual": None,
        "force_error": None,
        "hold": 0.2,
    }


def test_the_command_that_repeats_a_run(build: Build) -> None:
    folder = build(overrides=("trials.seed=3", "scene.friction=0.5", "trials.count=9", "about=it's"))
    command = repeating(folder)
    place = f"'{folder.path}/spec.yaml'"
    settings = "--set scene.friction=0.5 --set 'about=it'\"'\"'s'"
    assert command == f"graspdsl run {place} {settings} --trials 5 --seed 7"
