"""The page and the figures of a comparison."""

from __future__ import annotations

import re
from dataclasses import replace
from html.parser import HTMLParser
from pathlib import Path

import numpy as np
import pytest

from graspdsl.compiler.program import program_of
from graspdsl.diagnostics import DiagnosticError
from graspdsl.report.comparison import comparison
from graspdsl.report.comparison_figures import Side, convergence_figure, orientation_figure, residual_figure
from graspdsl.report.comparison_page import FIGURES, write_comparison
from graspdsl.report.comparison_tables import methods_of, tables_of
from graspdsl.report.evidence import gathered
from graspdsl.trials.runner import execute, new_run
from graspdsl.trials.store import RunFolder

SPECS = Path(__file__).resolve().parents[2] / "specs" / "compare"
VOID = {"meta", "img", "br", "path", "use", "rect", "circle", "line", "stop", "link"}


def run(folder: Path, name: str, *overrides: str, count: int | None = None) -> RunFolder:
    """A small run of one of the specs to compare; only begun for a count of 0."""
    text = (SPECS / name).read_text("utf-8")
    made = new_run(folder, program_of(text, name, overrides), text, name, overrides)
    if count != 0:
        execute(made, workers=1)
    return made


@pytest.fixture(scope="module")
def runs(tmp_path_factory: pytest.TempPathFactory) -> list[RunFolder]:
    """One that converges, one that mostly does not, one that never began; in folders with names to be escaped."""
    place = tmp_path_factory.mktemp("<i>&")
    return [
        run(place / "<script>", "moment_subject_to_force.yaml", "trials.count=8"),
        run(place / "b", "cstar.yaml", "trials.count=4", "about=a <b>"),
        run(place / "c", "cstar.yaml", count=0),
    ]


class Reader(HTMLParser):
    """Reads a page: what it refers to, its ids, and whether its elements close."""

    def __init__(self) -> None:
        super().__init__()
        self.open: list[str] = []
        self.ids: list[str] = []
        self.links: list[str] = []
        self.text = ""

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        """An element begins."""
        self.ids += [value or "" for name, value in attrs if name == "id"]
        self.links += [value or "" for name, value in attrs if name in ("href", "src", "xlink:href")]
        if tag not in VOID:
            self.open.append(tag)

    def handle_startendtag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        """An element without content."""
        self.handle_starttag(tag, attrs)
        if tag not in VOID:
            self.open.pop()

    def handle_endtag(self, tag: str) -> None:
        """An element ends."""
        if tag not in VOID:
            assert self.open.pop() == tag

    def handle_data(self, data: str) -> None:
        """Text."""
        self.text += data


def test_the_page_holds_all_and_needs_no_other_file(runs: list[RunFolder], tmp_path: Path) -> None:
    numbers = comparison(runs)
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
    for table in tables_of(numbers):
        assert table.title in reader.text
        assert all(cell in reader.text for row in table.rows for cell in row)
    assert all(method in reader.text for method in methods_of(numbers))
    assert "prefers-color-scheme: dark" in page
    with pytest.raises(DiagnosticError, match="not empty"):
        write_comparison(tmp_path / "out", runs, numbers)


def test_the_same_comparison_gives_the_same_files(runs: list[RunFolder], tmp_path: Path) -> None:
    numbers = comparison(runs)
    for name in ("a", "b"):
        write_comparison(tmp_path / name, runs, numbers)
    files = sorted(file.name for file in (tmp_path / "a").iterdir())
    assert len(files) == 2 + 2 * len(FIGURES)
    for name in files:
        assert (tmp_path / "a" / name).read_bytes() == (tmp_path / "b" / name).read_bytes()


def test_tables_have_a_cell_for_each_run(runs: list[RunFolder]) -> None:
    for table in tables_of(comparison(runs)):
        assert all(len(row) == len(table.columns) for row in table.rows)
        assert len(table.columns) in (len(runs), len(runs) + 1)  # a name, and all runs or all but the first


def test_figures_show_what_the_runs_did(runs: list[RunFolder]) -> None:
    """Curves end where the numbers say: the share converged, the mean residual of the last rows."""
    sides = [Side(f"run {place}", gathered(folder)) for place, folder in enumerate(runs)]
    curves = convergence_figure(sides).axes[0].get_lines()
    numbers = comparison(runs)["runs"]
    for curve, column in zip(curves, numbers, strict=True):
        assert np.asarray(curve.get_ydata())[-1] == pytest.approx(100.0 * (column["share"] or 0.0))
    for curve, side in zip(residual_figure(sides).axes[0].get_lines(), sides[:2], strict=False):
        ends = [record.force_residual_end for record in side.evidence.records]
        starts = [course.force[0] for course in side.evidence.courses.values()]
        drawn = np.asarray(curve.get_ydata())
        assert (drawn[0], drawn[-1]) == pytest.approx((np.mean(starts), np.mean(ends)), rel=1e-5)
    for curve in orientation_figure(sides).axes[0].get_lines()[:2]:
        assert np.trapezoid(curve.get_ydata(), curve.get_xdata()) == pytest.approx(1.0, abs=1e-3)


def test_runs_with_nothing_are_drawn(runs: list[RunFolder]) -> None:
    """No finished trial at all: figures without curves, no complaint."""
    side = Side("nothing", replace(gathered(runs[2])))
    for draw, _ in FIGURES.values():
        assert len(draw([side, side]).axes) >= 1
