"""What a report says of the stages of 'a then b': by the trajectories of a run."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from stored_runs import lose_trajectory, stored_run

from graspdsl.report.evidence import evidence_of
from graspdsl.report.page import page as page_of
from graspdsl.report.run_tables import brief_tables
from graspdsl.report.summary import plain, summarised

SPECS = Path(__file__).resolve().parents[2] / "specs" / "compare"


@pytest.mark.slow
def test_stages_are_counted_and_what_they_hand_over_is_measured(tmp_path: Path) -> None:
    """C* with hysteresis: as many ticks in all as the trials had, and every way back begins the force again."""
    folder = stored_run(tmp_path / "run", SPECS / "cstar_hysteresis.yaml", "trials.count=6", "trials.seed=52")
    summary = summarised(evidence_of(folder))
    force, moment = summary.stages
    rows = [folder.trajectory(number)["stage"] for number in range(6)]
    residuals = [folder.trajectory(number)["force_residual"] for number in range(6)]
    back = sum(int((np.diff(stage) < 0).sum()) for stage in rows)
    assert (force.trials, moment.trials, force.ended + moment.ended) == (6, 6, 6)
    assert (force.went_back, moment.went_back) == (0, back)
    assert back > 0
    assert force.ticks == np.median([(stage == 0).sum() for stage in rows])
    handed = [residual[1:][np.diff(stage) > 0] for residual, stage in zip(residuals, rows, strict=True)]
    assert force.force_residual == pytest.approx(np.median(np.concatenate(handed)))
    assert force.force_residual is not None
    assert force.force_residual < 0.1
    assert moment.force_residual is None
    assert "Stages: in which of them trials ended" in [table.title for table in brief_tables(summary)]
    assert plain(summary)["stages"][1]["controller"] == "φ_mr|τ_mrx(Γ_τ) σ_mr(Γ)"
    assert summary.known == ()


@pytest.mark.slow
def test_a_run_without_stages_tells_of_none_but_of_what_is_known(tmp_path: Path) -> None:
    folder = stored_run(tmp_path / "run", SPECS / "moment_subject_to_force.yaml", "trials.count=1")
    summary = summarised(evidence_of(folder))
    assert summary.stages == ()
    plain_sum, order, whole = summary.known
    assert plain_sum.startswith("◁ is a plain sum in φ_mr")
    assert "moves as φ_fr" in order
    assert "moves as φ_w" in whole


@pytest.mark.slow
def test_trials_whose_trajectories_are_lost_are_said_to_be_left_out(tmp_path: Path) -> None:
    folder = stored_run(tmp_path / "run", SPECS / "cstar.yaml", "trials.count=3", "program.0.limit=2")
    lose_trajectory(folder, 1)
    summary = summarised(evidence_of(folder))
    assert summary.lost == (1,)
    assert [stage.trials for stage in summary.stages] == [2, 2]
    notes = [made.note for made in brief_tables(summary) if "1 trial left out" in made.note]
    assert len(notes) == 2  # of stages and of modes


@pytest.mark.slow
def test_a_page_does_not_say_of_lost_trajectories_that_no_controller_took_over(tmp_path: Path) -> None:
    folder = stored_run(tmp_path / "run", SPECS / "cstar.yaml", "trials.count=2", "program.0.limit=2")
    for file in (folder.path / "trajectories").iterdir():
        file.unlink()
    evidence = evidence_of(folder)
    page = page_of(evidence, summarised(evidence), [])
    assert "No controller took over" not in page
    assert "Of 2 trials the trajectories cannot be read" in page
