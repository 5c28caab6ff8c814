"""Runs that keep less of their trajectories: what trials measure is the same, and pages say what they lack."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path

import pytest
from stored_runs import stored_run

from graspdsl.report.evidence import Evidence, evidence_of
from graspdsl.report.page import drawings_of, page
from graspdsl.report.summary import summarised
from graspdsl.trials.record import TrialRecord

SPEC = Path(__file__).parents[2] / "specs" / "chapter" / "4_30_grasp_cartesian.yaml"
KEPT = ("all", "every=7", "ends", "none")

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def kept(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Evidence]:
    """The same run, by what was kept of it."""
    place = tmp_path_factory.mktemp("kept")
    return {keep: evidence_of(stored_run(place / keep, SPEC, "trials.count=5", f"trials.keep={keep}")) for keep in KEPT}


def _measured(evidence: Evidence) -> list[str]:
    """What stands in the records, to the last bit, their identities too."""
    return [repr(replace(record, wall_s=0.0)) for record in evidence.records]


def test_what_trials_measure_does_not_depend_on_what_is_kept(kept: dict[str, Evidence]) -> None:
    assert [_measured(kept[keep]) for keep in KEPT] == [_measured(kept["all"])] * 4
    assert [len(evidence.lost) for evidence in kept.values()] == [0] * 4


def test_how_grasps_end_is_told_whatever_is_kept(kept: dict[str, Evidence]) -> None:
    told = {keep: [evidence.touching(record) for record in evidence.records] for keep, evidence in kept.items()}
    assert [told[keep] for keep in KEPT] == [[True] * 5] * 4
    modes = {keep: summarised(evidence).modes for keep, evidence in kept.items()}
    assert modes["all"] == modes["every=7"] == modes["ends"] == modes["none"] != ()


def test_courses_are_told_at_every_tick_by_those_that_were_kept(kept: dict[str, Evidence]) -> None:
    for number, whole in kept["all"].courses.items():
        thinned, record = kept["every=7"].courses[number], _record(kept["all"], number)
        assert len(thinned.force) == len(whole.force) == record.samples
        ticks = kept["every=7"].trajectory(number)
        assert ticks is not None
        begun = int(ticks["tick"][-1]) + 1 - record.samples
        at_kept = [int(tick) - begun for tick in ticks["tick"] if tick >= begun]
        assert thinned.force[at_kept].tolist() == whole.force[at_kept].tolist()
        assert len(kept["ends"].courses[number].force) == 0


def _record(evidence: Evidence, number: int) -> TrialRecord:
    return next(record for record in evidence.records if record.number == number)


@pytest.mark.parametrize(
    ("keep", "said"),
    [
        ("all", None),
        ("every=7", "kept every=7 of its ticks and the last one"),
        ("ends", "kept the ends of its trajectories"),
        ("none", "kept nothing of its trajectories"),
    ],
)
def test_pages_say_what_was_kept(keep: str, said: str | None, kept: dict[str, Evidence]) -> None:
    text = re.sub(
        r"\s+", " ", page(kept[keep], summarised(kept[keep]), drawings_of(kept[keep], summarised(kept[keep])))
    )
    assert ("The run kept" in text) is (said is not None)
    assert said is None or said in text
    assert "Left out at the end" not in text
    assert "No controller took over" not in text
