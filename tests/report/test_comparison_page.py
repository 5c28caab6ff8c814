"""The page and the figures of a comparison."""

from __future__ import annotations

import csv
import json
import re
from pathlib import Path

import numpy as np
import pytest
from stored_runs import stored_run

from graspdsl.diagnostics import DiagnosticError
from graspdsl.report.comparison import Comparison, comparison, comparison_tables, methods_of
from graspdsl.report.comparison_page import (
    FIGURES,
    Side,
    convergence_figure,
    orientation_figure,
    residual_figure,
    write_comparison,
)
from graspdsl.report.evidence import Evidence, evidence_of
from graspdsl.report.summary import summarised
from report.reader import Reader, untold

SPECS = Path(__file__).resolve().parents[2] / "specs" / "compare"


@pytest.fixture(scope="module")
def runs(tmp_path_factory: pytest.TempPathFactory) -> list[Evidence]:
    """One that converges, one that mostly does not, one that never began; in folders with names to be escaped."""
    place = tmp_path_factory.mktemp("<i>&")
    folders = [
        stored_run(place / "<script>", SPECS / "moment_subject_to_force.yaml", "trials.count=8"),
        stored_run(place / "b", SPECS / "cstar.yaml", "trials.count=4", "about=a <b>"),
        stored_run(place / "c", SPECS / "cstar.yaml", begun=False),
    ]
    return [evidence_of(folder) for folder in folders]


def compared(runs: list[Evidence]) -> Comparison:
    """The comparison of runs."""
    return comparison([(evidence, summarised(evidence)) for evidence in runs])


@pytest.mark.slow
def test_the_page_holds_all_and_needs_no_other_file(runs: list[Evidence], tmp_path: Path) -> None:
    numbers = compared(runs)
    write_comparison(tmp_path / "out", runs, numbers)
    page = (tmp_path / "out" / "compare.html").read_text("utf-8")
    reader = Reader()
    reader.feed(page)
    assert reader.open == []
    assert len(set(reader.ids)) == len(reader.ids)
    assert all(link.startswith("#") and link[1:] in reader.ids for link in reader.links)
    assert not re.search(r"url\((?!#)|@import|<script", page)
    assert "<script>" in reader.text  # the name of a folder, as text
    assert reader.text.count("2: compare-cstar, about=a <b>") == len(FIGURES)  # and a setting, in each legend
    for table in comparison_tables(numbers):
        assert table.title in reader.text
        assert all(cell.text in reader.text for row in table.cells() for cell in row)
    assert all(method in reader.text for method in methods_of(numbers))
    assert "prefers-color-scheme: dark" in page
    assert untold(page, json.loads((tmp_path / "out" / "compare.json").read_text("utf-8"))) == set()
    with pytest.raises(DiagnosticError, match="not empty"):
        write_comparison(tmp_path / "out", runs, numbers)


@pytest.mark.slow
def test_the_same_comparison_gives_the_same_files(runs: list[Evidence], tmp_path: Path) -> None:
    numbers = compared(runs)
    for name in ("a", "b"):
        write_comparison(tmp_path / name, runs, numbers)
    files = sorted(file.name for file in (tmp_path / "a").iterdir())
    assert len(files) == 2 + 4 * len(FIGURES)
    for name in files:
        assert (tmp_path / "a" / name).read_bytes() == (tmp_path / "b" / name).read_bytes()


def test_tables_have_a_cell_for_each_run(runs: list[Evidence]) -> None:
    for table in comparison_tables(compared(runs)):
        assert all(len(row) == len(table.columns) for row in table.rows)
        assert len(table.columns) in (len(runs), len(runs) + 1)  # a name, and all runs or all but the first


def test_figures_show_what_the_runs_did(runs: list[Evidence]) -> None:
    """Curves end where the numbers say: the share converged, the mean residual of the last rows."""
    sides = [Side.of(f"run {place}", evidence) for place, evidence in enumerate(runs)]
    curves = convergence_figure(sides).axes[0].get_lines()
    numbers = compared(runs).runs
    for curve, column in zip(curves, numbers, strict=True):
        assert np.asarray(curve.get_ydata())[-1] == pytest.approx(100.0 * (column.summary.converged.share or 0.0))
    for curve, evidence in zip(residual_figure(sides).axes[0].get_lines(), runs[:2], strict=False):
        ends = [record.force_residual_end for record in evidence.records]
        starts = [course.force[0] for course in evidence.courses.values()]
        drawn = np.asarray(curve.get_ydata())
        assert (drawn[0], drawn[-1]) == pytest.approx((np.mean(starts), np.mean(ends)), rel=1e-5)
    for curve in orientation_figure(sides).axes[0].get_lines()[:2]:
        assert np.trapezoid(curve.get_ydata(), curve.get_xdata()) == pytest.approx(1.0, abs=1e-3)


@pytest.mark.slow
def test_what_a_figure_draws_is_written_beside_it(runs: list[Evidence], tmp_path: Path) -> None:
    write_comparison(tmp_path / "out", runs, compared(runs))
    sides = [Side.of(f"run {place}", evidence) for place, evidence in enumerate(runs)]
    for name, (draw, *_) in FIGURES.items():
        rows = list(csv.DictReader((tmp_path / "out" / f"{name}.csv").open(encoding="utf-8")))
        units = json.loads((tmp_path / "out" / f"{name}.units.json").read_text("utf-8"))
        assert {*units} == {*rows[0]}
        abscissa, height = [column for column, unit in units.items() if unit][1:3]
        scale = 100.0 if height == "share" else 1.0
        for place, line in enumerate(draw(sides).axes[0].get_lines(), 1):
            own = [row for row in rows if row["run"] == str(place)]
            told = {(f"{float(row[abscissa]):.9g}", f"{scale * float(row[height]):.9g}") for row in own}
            drawn = {(f"{x:.9g}", f"{y:.9g}") for x, y in np.asarray(line.get_xydata()) if np.isfinite(y)}
            assert told <= drawn
            assert len(drawn - told) <= 2 * (name == "convergence")  # where its steps begin and end


def test_runs_with_nothing_are_drawn(runs: list[Evidence]) -> None:
    """No finished trial at all: figures without curves, no complaint."""
    side = Side.of("nothing", runs[2])
    for draw, *_ in FIGURES.values():
        assert len(draw([side, side]).axes) >= 1
