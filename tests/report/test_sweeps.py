"""What is said of a sweep: its points, what changed with a field, its figures; also while trials are missing."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from compiler.specs import floating
from scipy.stats import spearmanr

import graspdsl as g
from graspdsl.compiler.program import program_of
from graspdsl.report.statistics import difference_of_medians, rank_correlation
from graspdsl.report.sweep_page import drawings_of_sweep
from graspdsl.report.sweeps import changes_tables, correlations_table, labels_of, points_table, verdict
from graspdsl.trials.record import TrialRecord
from graspdsl.trials.runner import execute, new_run

COUNT, UNTIL = 6, "force_residual: 0.1"
GRID = "{grid: {control.step: [0.001, 0.004], control.nullspace: [gradient, task], scene.friction: [0.3, 0.4]}}"
DRAWN = "{random: {points: 7, seed: 2, over: {control.step: {uniform: [0.0005, 0.002]}}}}"


def swept(place: Path, sweep: str, stop_after: int | None = None) -> g.Sweep:
    """A sweep of a floating spec, or as many of its trials as are asked for."""
    program = program_of(f"{floating(until=UNTIL)}trials: {{count: {COUNT}}}\nsweep: {sweep}\n", "spec.yaml")
    folder, told = new_run(place, program), list[int]()

    def stop(record: TrialRecord) -> None:
        told.append(record.number)
        if len(told) == stop_after:
            raise KeyboardInterrupt

    try:
        execute(folder, 1, stop)
    except KeyboardInterrupt:
        assert stop_after
    return g.open_sweep(place)


@pytest.fixture(scope="module")
def grid(tmp_path_factory: pytest.TempPathFactory) -> g.Sweep:
    """Eight points, not to be written to."""
    return swept(tmp_path_factory.mktemp("grid") / "run", GRID)


@pytest.mark.slow
def test_a_point_is_told_as_its_own_run_is(grid: g.Sweep) -> None:
    assert len(grid) == len(grid.summary.points) == 8
    for run, point in zip(grid, grid.summary.points, strict=True):
        assert (point.share, point.interval) == (run.summary.converged.share, run.summary.converged.interval)
        columns = run.columns()
        assert point.medians["orientation_end"] == np.median(columns["orientation_end"])
        assert point.outcomes == run.summary.outcomes
        assert run.path == grid.path / "points" / f"{point.number:03d}"
    converged = [run.summary.outcomes.get("converged", 0) for run in grid]
    assert (grid.summary.finished, grid.summary.converged) == (8 * COUNT, sum(converged))
    assert len({*converged}) > 1


@pytest.mark.slow
def test_a_change_is_of_one_field_and_against_its_first_value(grid: g.Sweep) -> None:
    points = grid.points
    assert len(grid.summary.changes) == 12  # half of eight points for each of three fields
    for change in grid.summary.changes:
        one, base = points[change.point], points[change.base]
        assert [field for field in one if one[field] != base[field]] == [change.field]
        assert base[change.field or ""] == points[0][change.field or ""]
    [change] = [one for one in grid.summary.changes if one.field == "control.step" and one.base == 3]
    assert points[change.point] == {**points[3], "control.step": 0.004}
    ours, theirs = (grid[at].columns()["orientation_end"] for at in (change.point, change.base))
    assert change.against.differences["orientation_end"] == difference_of_medians(ours, theirs, paired=True)
    assert change.against.pairs == COUNT


@pytest.mark.slow
def test_the_page_has_a_figure_and_a_table_for_each_field(grid: g.Sweep) -> None:
    drawings = drawings_of_sweep(grid.summary)
    assert [drawing.name for drawing in drawings] == [f"sweep-{field}" for field in grid.summary.fields]
    assert list(changes_tables(grid.summary)) == list(grid.summary.fields)
    legends = [text.get_text() for text in drawings[0].figure.legends[0].get_texts()]
    assert legends[:2] == ["nullspace gradient, friction 0.3", "nullspace gradient, friction 0.4"]
    ticks = drawings[0].figure.axes[1].get_lines()[0]
    medians = [np.nanmedian(grid[at].columns()["ticks_to_converge"]) for at in (0, 4)]
    assert np.allclose(ticks.get_ydata(), medians)
    page = grid.report().read_text("utf-8")
    for field in grid.summary.fields:
        assert f"<h2>{field}</h2>" in page
        assert f"Differences with {labels_of(list(grid.summary.fields))[field]}, all else the same" in page
    assert verdict(grid.summary).startswith(f"{grid.summary.converged} of 48 trials converged at 8 points: from ")


@pytest.mark.slow
def test_points_that_were_drawn_are_held_against_the_first_and_ranked(tmp_path: Path) -> None:
    found = swept(tmp_path / "run", DRAWN).summary
    assert [(change.field, change.base) for change in found.changes] == [(None, 0)] * 6
    [ticks] = [one for one in found.correlations if one.measure == "ticks_to_converge"]
    x, y = zip(
        *((point.values["control.step"], point.medians["ticks_to_converge"]) for point in found.points), strict=True
    )
    assert math.isclose(ticks.estimate.value, spearmanr(x, y).statistic)
    assert {one.field for one in found.correlations} == {"control.step"}
    assert correlations_table(found).rows
    assert all(drawing.figure.axes[0].get_lines()[0].get_linestyle() == "None" for drawing in drawings_of_sweep(found))


@pytest.mark.slow
@pytest.mark.parametrize("finished", [1, COUNT + 2])
def test_an_unfinished_sweep_is_told_as_far_as_it_is(tmp_path: Path, finished: int) -> None:
    found = swept(tmp_path / "run", GRID, stop_after=finished)
    assert [point.finished for point in found.summary.points][:3] == [min(finished, COUNT), max(0, finished - COUNT), 0]
    assert found.summary.points[7].share is None
    assert points_table(found.summary).cells()[7][-1].text == "–"
    assert found.report().is_file()


def test_fields_are_called_by_what_tells_them_apart() -> None:
    fields = ["scene.object.sphere.diameter", "control.step", "scene.object.cylinder.diameter", "step"]
    assert list(labels_of(fields).values()) == ["sphere.diameter", "control.step", "cylinder.diameter", "step"]


def test_rank_correlations_hold_the_truth_as_often_as_they_say() -> None:
    """Of pairs of a normal law with a known rank correlation, (6/π)·asin(r/2)."""
    random, truth, held = np.random.default_rng(8), 6 / math.pi * math.asin(0.3), 0
    for _ in range(100):
        drawn = random.multivariate_normal([0, 0], [[1, 0.6], [0.6, 1]], size=30)
        found = rank_correlation(drawn[:, 0], drawn[:, 1])
        assert found
        assert found.interval
        assert math.isclose(found.value, spearmanr(*drawn.T).statistic)
        held += found.interval[0] <= truth <= found.interval[1]
    assert held >= 86  # four standard errors below 95


def test_there_is_no_correlation_of_few_or_with_what_never_changes() -> None:
    six = np.arange(6.0)
    assert rank_correlation(six[:5], six[:5]) is None
    assert rank_correlation(six, np.ones(6)) is None
    ties = rank_correlation(six, np.array([1.0, 1, 1, 1, 1, 2]))
    assert ties
    assert ties.interval == (-1.0, 1.0)  # a third of all resamples lack the one that differs


@pytest.mark.slow
def test_all_that_a_sweep_says_is_exported(grid: g.Sweep, tmp_path: Path) -> None:
    assert grid.tables == ["trials", "points", "differences"]
    points, differences, trials = (grid.table(name) for name in ("points", "differences", "trials"))
    for point in grid.summary.points:
        row = {name: points[name][point.number] for name in points}
        assert (row["point"], row["share"], row["control.step"]) == (
            point.number,
            point.share,
            point.values["control.step"],
        )
        assert (row["share.low"], row["share.high"]) == point.interval
        assert row["control.nullspace"] == point.values["control.nullspace"]
        assert [row[f"orientation_end.p{at}"] for at in (10, 25, 50, 75, 90)] == list(point.orientations or ())
    assert (points.units["control.step"], points.units["control.nullspace"]) == ("m", "")
    for place, change in enumerate(grid.summary.changes):
        estimate = change.against.converged
        assert estimate
        assert differences["share"][place] == estimate.value
        assert (differences["field"][place], differences["against"][place]) == (change.field, change.base)
    assert trials["point"].tolist() == [point for point in range(8) for _ in range(COUNT)]
    for run, at in zip(grid, range(0, 8 * COUNT, COUNT), strict=True):
        assert np.array_equal(trials["orientation_end"][at : at + COUNT], run.columns()["orientation_end"])
    assert trials.units["orientation_end"] == "rad"
    folder = grid.export(tmp_path / "all", "all")
    assert sorted(file.name for file in folder.glob("*.csv")) == ["differences.csv", "points.csv", "trials.csv"]
    assert grid.figures == [f"sweep-{field}" for field in grid.summary.fields]


@pytest.mark.slow
def test_trials_of_points_that_measure_other_things_are_one_table(tmp_path: Path) -> None:
    found = swept(tmp_path / "run", "{list: [{evaluate: [force-closure]}, {evaluate: []}]}")
    closed = found.columns()["quality.force-closure.closed"]
    assert np.isfinite(closed[:COUNT]).all()
    assert np.isnan(closed[COUNT:]).all()
    assert found.columns()["evaluate"][[0, -1]].tolist() == ['["force-closure"]', "[]"]
