"""A comparison as files: its figures, its numbers, and one page that holds all of it."""

from __future__ import annotations

import json
import textwrap
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path

from markupsafe import Markup, escape
from matplotlib.figure import Figure

from graspdsl.report.comparison import Comparison, comparison_tables, methods_of
from graspdsl.report.comparison_figures import Side, convergence_figure, orientation_figure, residual_figure
from graspdsl.report.drawing import inline_svg, png_of, svg_of
from graspdsl.report.evidence import Evidence
from graspdsl.report.summary import plain
from graspdsl.report.templating import DrawnFigure, rendered
from graspdsl.report.writing import prepare
from graspdsl.trials.store import RunFolder

LONGEST_LABEL = 70  # characters
PAGE, NUMBERS = "compare.html", "compare.json"
FIGURES: Mapping[str, tuple[Callable[[Sequence[Side]], Figure], str]] = {
    "orientation": (
        orientation_figure,
        "Densities of the orientation of grasps at the end of each run's trials, over all that have one.",
    ),
    "residuals": (
        residual_figure,
        "Residuals since the controller took over: the mean over trials, and the band from their 10th to their 90th "
        "percentile. A trial that has ended keeps its last residuals; a curve ends with its run's longest trial.",
    ),
    "convergence": (
        convergence_figure,
        "The share of each run's finished trials that have converged within so many ticks, or probes where contacts "
        "are displaced by probing.",
    ),
}


def write_comparison(place: Path, evidences: Sequence[Evidence], found: Comparison) -> None:
    """Write the figures, the numbers and the page of a comparison into an empty or new folder.

    Raises DiagnosticError where it cannot.
    """
    sides = [Side(_label(number, evidence.folder), evidence) for number, evidence in enumerate(evidences, 1)]
    files: dict[str, str | bytes] = {NUMBERS: json.dumps(plain(found), indent=2, allow_nan=False) + "\n"}
    drawn = []
    for name, (draw, caption) in FIGURES.items():
        figure = draw(sides)
        files[f"{name}.svg"], files[f"{name}.png"] = svg_of(figure, name), png_of(figure)
        drawn.append(DrawnFigure(Markup(inline_svg(svg_of(figure, name), name, str(escape(caption)))), caption))
    files[PAGE] = page(found, drawn)
    prepare(place, files)


def _label(number: int, folder: RunFolder) -> str:
    whole = ", ".join([f"{number}: {folder.manifest.name}", *folder.manifest.settings])
    return textwrap.shorten(whole, LONGEST_LABEL, placeholder=" …")


def page(found: Comparison, figures: Sequence[DrawnFigure]) -> str:
    """The page of a comparison: one file that needs no other."""
    return rendered(
        "compare.html",
        runs=found.runs,
        tables=comparison_tables(found),
        methods=methods_of(found),
        figures=figures,
    )
