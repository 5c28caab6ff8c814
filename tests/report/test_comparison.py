"""Runs side by side: pairs, ratios and their intervals."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from graspdsl.compiler.program import program_of
from graspdsl.report.comparison import comparison
from graspdsl.trials.outcomes import Outcome
from graspdsl.trials.record import Trial
from graspdsl.trials.runner import execute, new_run
from graspdsl.trials.store import RunFolder

SPECS = Path(__file__).resolve().parents[2] / "specs" / "compare"


def run(folder: Path, name: str, *overrides: str) -> RunFolder:
    """A small run of one of the specs to compare."""
    text = (SPECS / name).read_text("utf-8")
    program = program_of(text, name, overrides)
    made = new_run(folder, program, text, name, overrides)
    execute(made, workers=1)
    return made


@pytest.fixture(scope="module")
def composite(tmp_path_factory: pytest.TempPathFactory) -> RunFolder:
    """Twelve trials of the composite controller."""
    return run(tmp_path_factory.mktemp("runs") / "composite", "moment_subject_to_force.yaml", "trials.count=12")


def test_a_run_equals_itself(composite: RunFolder) -> None:
    """Every ratio is one with an interval of no width, and every trial is a pair."""
    [against] = comparison([composite, composite])["against_first"]
    assert against["pairs"] == sum(record.outcome is Outcome.CONVERGED for record in composite.records())
    assert against["orientation_difference"] == 0.0
    for ratio in against["ratios"].values():
        assert ratio == {"value": 1.0, "interval": [1.0, 1.0]}


def test_a_known_ratio_is_found(composite: RunFolder, tmp_path: Path) -> None:
    """A run whose trials take three times as long has that ratio, and medians are numpy's."""
    text = (SPECS / "moment_subject_to_force.yaml").read_text("utf-8")
    overrides = ("trials.count=12",)
    slow = new_run(tmp_path / "slow", program_of(text, "s", overrides), text, "s", overrides)
    for record in composite.records():
        slow.add(Trial(replace(record, world_s=3.0 * record.world_s), composite.trajectory(record.number)))
    numbers = comparison([composite, slow])
    assert numbers["against_first"][0]["ratios"]["world_s"]["value"] == pytest.approx(3.0)
    good = [record for record in composite.records() if record.outcome is Outcome.CONVERGED]
    assert numbers["runs"][0]["medians"]["world_s"] == pytest.approx(np.median([record.world_s for record in good]))
    low, high = numbers["against_first"][0]["ratios"]["world_s"]["interval"]
    assert low <= 3.0 <= high


def test_runs_of_other_seeds_are_not_paired(composite: RunFolder, tmp_path: Path) -> None:
    """Without equal starts there are no pairs, but still a ratio with an interval."""
    other = run(tmp_path / "other", "moment_subject_to_force.yaml", "trials.count=12", "trials.seed=99")
    [against] = comparison([composite, other])["against_first"]
    assert against["pairs"] == 0
    assert against["orientation_difference"] is None
    low, high = against["ratios"]["ticks"]["interval"]
    assert low <= against["ratios"]["ticks"]["value"] <= high


def test_a_run_without_convergence_has_no_ratio(composite: RunFolder, tmp_path: Path) -> None:
    """Nothing converged, nothing to compare: None, not a number out of nowhere."""
    hopeless = run(tmp_path / "hopeless", "moment_alone.yaml", "trials.count=2", "program.0.limit=0.5")
    numbers = comparison([composite, hopeless])
    assert numbers["runs"][1]["medians"]["world_s"] is None
    assert set(numbers["against_first"][0]["ratios"].values()) == {None}
