"""Runs side by side: pairs, ratios and their intervals."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from stored_runs import stored_run

from graspdsl.report.comparison import Comparison, comparison_tables
from graspdsl.report.comparison import comparison as comparison_of
from graspdsl.report.evidence import evidence_of
from graspdsl.report.statistics import UNPAIRED_MEDIANS, UNPAIRED_SHARES
from graspdsl.report.summary import plain, summarised
from graspdsl.trials.outcomes import Outcome
from graspdsl.trials.record import Trial
from graspdsl.trials.store import RunFolder

pytestmark = pytest.mark.slow

SPECS = Path(__file__).resolve().parents[2] / "specs" / "compare"
TOWEL = SPECS.parent / "towel_roll_two_contacts.yaml"


@pytest.fixture(scope="module")
def composite(tmp_path_factory: pytest.TempPathFactory) -> RunFolder:
    """Twelve trials of the composite controller."""
    return stored_run(
        tmp_path_factory.mktemp("runs") / "composite", SPECS / "moment_subject_to_force.yaml", "trials.count=12"
    )


def compared(folders: Sequence[RunFolder]) -> Comparison:
    """The comparison of runs."""
    return comparison_of([(evidence, summarised(evidence)) for evidence in map(evidence_of, folders)])


def comparison(folders: Sequence[RunFolder]) -> Any:
    """The comparison of runs as JSON has it."""
    return plain(compared(folders))


def test_a_run_equals_itself(composite: RunFolder) -> None:
    """Every ratio is one with an interval of no width, and every trial is a pair."""
    [against] = comparison([composite, composite])["against_first"]
    assert against["pairs"] == len(composite.records())
    assert against["paired"]
    assert against["orientation_difference"] == 0.0
    for ratio in against["ratios"].values():
        assert (ratio["value"], ratio["interval"]) == (1.0, [1.0, 1.0])
    for difference in against["differences"].values():
        assert (difference["value"], difference["interval"]) == (0.0, [0.0, 0.0])
    low, high = against["converged"]["interval"]
    assert against["converged"]["value"] == 0.0
    assert low == -high


def test_a_known_ratio_is_found(composite: RunFolder, tmp_path: Path) -> None:
    """A run whose trials take three times as long has that ratio, and medians are numpy's."""
    slow = stored_run(tmp_path / "slow", SPECS / "moment_subject_to_force.yaml", "trials.count=12", begun=False)
    for record in composite.records():
        slow.add(Trial(replace(record, world_s=3.0 * record.world_s), composite.trajectory(record.number)).packed())
    numbers = comparison([composite, slow])
    assert numbers["against_first"][0]["ratios"]["world_s"]["value"] == pytest.approx(3.0)
    good = [record for record in composite.records() if record.outcome is Outcome.CONVERGED]
    assert numbers["runs"][0]["medians"]["world_s"] == pytest.approx(np.median([record.world_s for record in good]))
    low, high = numbers["against_first"][0]["ratios"]["world_s"]["interval"]
    assert low <= 3.0 <= high


def test_a_ratio_without_an_upper_end_is_said_and_stored(composite: RunFolder, tmp_path: Path) -> None:
    """Against a run nearly half of whose trials cost nothing: ∞ in the table, null in the document."""
    free = stored_run(tmp_path / "free", SPECS / "moment_subject_to_force.yaml", "trials.count=12", begun=False)
    good = [record.number for record in composite.records() if record.outcome is Outcome.CONVERGED]
    costless = good[: (len(good) - 1) // 2]
    for record in composite.records():
        spent = 0.0 if record.number in costless else record.world_s
        free.add(Trial(replace(record, world_s=spent), composite.trajectory(record.number)).packed())
    numbers = comparison([free, composite])
    ratio = json.loads(json.dumps(numbers, allow_nan=False))["against_first"][0]["ratios"]["world_s"]
    assert ratio["interval"][1] is None
    [*_, against] = comparison_tables(compared([free, composite]))
    [row] = [
        row for row in against.cells() if row[0].text.startswith("time of a trial") and row[0].text.endswith("ratio")
    ]
    assert row[1].text.endswith("to ∞")


def test_runs_of_other_seeds_are_not_paired(composite: RunFolder, tmp_path: Path) -> None:
    """Without equal starts there are no pairs, but still ratios and differences with intervals."""
    other = stored_run(tmp_path / "other", SPECS / "moment_subject_to_force.yaml", "trials.count=12", "trials.seed=99")
    [against] = comparison([composite, other])["against_first"]
    assert against["pairs"] == 0
    assert against["orientation_difference"] is None
    low, high = against["ratios"]["ticks"]["interval"]
    assert low <= against["ratios"]["ticks"]["value"] <= high
    assert against["converged"]["method"] == UNPAIRED_SHARES
    assert against["differences"]["ticks"]["method"] == UNPAIRED_MEDIANS


def test_a_run_without_convergence_has_no_ratio(composite: RunFolder, tmp_path: Path) -> None:
    """Nothing converged, nothing to compare: None, not a number out of nowhere."""
    hopeless = stored_run(tmp_path / "hopeless", SPECS / "moment_alone.yaml", "trials.count=2", "program.0.limit=0.5")
    numbers = comparison([composite, hopeless])
    assert numbers["runs"][1]["medians"]["world_s"] is None
    [against] = numbers["against_first"]
    assert set(against["ratios"].values()) == {None}
    assert against["differences"]["ticks"] is None
    shares = [record.outcome is Outcome.CONVERGED for record in composite.records()[:2]]
    assert against["pairs"] == 2
    assert against["only_first_converged"] == sum(shares)
    assert against["converged"]["value"] == -np.mean(shares)


def test_a_run_that_has_not_begun_is_compared(composite: RunFolder, tmp_path: Path) -> None:
    """No finished trial: no share, no difference, no complaint, whichever stands first."""
    empty = stored_run(tmp_path / "empty", SPECS / "cstar.yaml", begun=False)
    for folders in ([composite, empty], [empty, composite], [empty, empty]):
        numbers = comparison(folders)
        [against] = numbers["against_first"]
        assert (against["pairs"], against["paired"], against["converged"]) == (0, False, None)
        assert set(against["differences"].values()) <= {None}
        at = folders.index(empty)
        assert (numbers["runs"][at]["share"], numbers["runs"][at]["outcomes"]) == (None, {})
        json.dumps(numbers, allow_nan=False)


def hand_run(folder: Path, composite: RunFolder, starts: list[dict[str, float]], good: list[bool]) -> RunFolder:
    """A run in the bullet world whose trials drew these starts and did or did not converge."""
    made = stored_run(folder, TOWEL, begun=False)
    pattern = composite.records()[0]
    for number, (start, converged) in enumerate(zip(starts, good, strict=True)):
        outcome = Outcome.CONVERGED if converged else Outcome.TIMEOUT
        made.add(Trial(replace(pattern, number=number, start=start, outcome=outcome), composite.trajectory(0)).packed())
    return made


def test_hands_pair_by_what_was_drawn(composite: RunFolder, tmp_path: Path) -> None:
    """Trials pair by number and drawn values; one that never got a start has no partner."""
    drawn = [{"roll": 0.1 * number} for number in range(8)]
    first = hand_run(tmp_path / "a", composite, drawn, [True] * 8)
    other = hand_run(tmp_path / "b", composite, [*drawn[:5], {"roll": 9.0}, {}, drawn[7]], [False] * 3 + [True] * 5)
    [against] = comparison([first, other])["against_first"]
    assert (against["pairs"], against["paired"]) == (6, True)
    assert (against["only_first_converged"], against["only_other_converged"]) == (3, 0)
    assert against["converged"]["value"] == -0.5
    [against] = comparison([other, hand_run(tmp_path / "c", composite, [{}] * 8, [True] * 8)])["against_first"]
    assert (against["pairs"], against["paired"]) == (0, False)


def test_few_pairs_among_many_trials_are_not_used(composite: RunFolder, tmp_path: Path) -> None:
    """Three pairs of eight trials would throw most of the trials away."""
    drawn = [{"roll": 0.1 * number} for number in range(8)]
    first = hand_run(tmp_path / "a", composite, drawn, [True] * 8)
    other = hand_run(tmp_path / "b", composite, [*drawn[:3], *[{"roll": 9.0}] * 5], [False] * 8)
    [against] = comparison([first, other])["against_first"]
    assert (against["pairs"], against["paired"], against["converged"]["value"]) == (3, False, -1.0)


def test_contacts_on_another_object_did_not_begin_alike(composite: RunFolder, tmp_path: Path) -> None:
    """In the floating world nothing is drawn but by the seed, over the object."""
    change = "scene.object={ellipsoid: {size: [0.1, 0.1, 0.3]}}"
    other = stored_run(tmp_path / "other", SPECS / "moment_subject_to_force.yaml", "trials.count=3", change)
    assert comparison([composite, other])["against_first"][0]["pairs"] == 0
