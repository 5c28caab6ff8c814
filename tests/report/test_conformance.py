"""The chapter's claims against runs of its experiments, small ones, and against numbers worked out by hand."""

from __future__ import annotations

import math
from collections.abc import Mapping
from pathlib import Path

import numpy as np
import pytest

from graspdsl.compiler.program import program_of
from graspdsl.report.conformance import EXPERIMENTS, SETTLED, Claim, _settled, claims_of
from graspdsl.report.evidence import Evidence, gathered
from graspdsl.trials.runner import execute, new_run

SPECS = Path(__file__).parents[2] / "specs" / "experiments"
COUNT = 3


@pytest.fixture(scope="module")
def runs(tmp_path_factory: pytest.TempPathFactory) -> Mapping[str, Evidence]:
    """A few trials of each experiment, on the free wrist and ungraded, which is quicker."""
    overrides = ("evaluate=[]", "scene.mount=gantry", f"trials.count={COUNT}", "trials.seed=5")
    found = {}
    for spec in sorted(SPECS.glob("*.yaml")):
        text = spec.read_text("utf-8")
        program = program_of(text, spec.name, overrides)
        folder = new_run(tmp_path_factory.mktemp("runs") / spec.stem, program, text, spec.name, overrides)
        execute(folder, workers=1)
        found[program.spec.name] = gathered(folder)
    return found


def claim_that(claims: list[Claim], words: str) -> Claim:
    """The one claim that says something."""
    [found] = [claim for claim in claims if words in claim.says]
    return found


def test_every_experiment_is_there(runs: Mapping[str, Evidence]) -> None:
    assert set(runs) == set(EXPERIMENTS)
    for evidence in runs.values():
        claims = claims_of(evidence)
        assert len(claims) >= 3
        assert all(claim.measured for claim in claims)
        assert all(claim.why or claim.agrees or "perpendicular" in claim.says for claim in claims)


@pytest.mark.parametrize("name", ["experiment-3", "experiment-4"])
def test_a_perpendicular_grasp_is_one_near_a_right_angle(runs: Mapping[str, Evidence], name: str) -> None:
    evidence = runs[name]
    ends = [record.orientation_end for record in evidence.records if evidence.touching(record)]
    together = max(ends) - min(ends) < 0.1
    upright = all(abs(end - math.pi / 2) < 0.1 for end in ends)
    claim = claim_that(claims_of(evidence), "perpendicular")
    if together:
        assert claim.agrees == upright


def test_the_share_of_grasps_that_are_stuck(runs: Mapping[str, Evidence]) -> None:
    evidence = runs["experiment-2"]
    ends = [record.orientation_end for record in evidence.records if evidence.touching(record)]
    stuck = sum(0.8 <= end <= math.pi / 2 for end in ends)
    claim = claim_that(claims_of(evidence), "significant number")
    assert f"of {len(ends)} that" in claim.measured
    assert claim.agrees == (stuck >= 2)


def test_a_run_of_something_else_has_no_claims(runs: Mapping[str, Evidence], tmp_path: Path) -> None:
    text = (SPECS / "1_towel_roll_two_contacts.yaml").read_text("utf-8").replace("name: experiment-1", "name: mine")
    folder = new_run(tmp_path / "mine", program_of(text, "mine.yaml"), text, "mine.yaml", ())
    assert claims_of(gathered(folder)) == []
    del runs


def test_no_trials_agree_with_nothing(tmp_path: Path) -> None:
    for spec in sorted(SPECS.glob("*.yaml")):
        text = spec.read_text("utf-8")
        folder = new_run(tmp_path / spec.stem, program_of(text, spec.name), text, spec.name, ())
        assert not any(claim.agrees for claim in claims_of(gathered(folder)))


def test_a_course_has_settled_when_most_of_its_way_is_done() -> None:
    course = np.exp(-np.arange(200) / 20.0)
    tick = _settled(course)
    way = course[0] - course[-1]
    assert course[tick] <= course[0] - SETTLED * way < course[tick - 1]
