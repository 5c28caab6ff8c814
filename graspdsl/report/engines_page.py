"""Engines as a page: its tables, its figure, and its numbers as data."""

from __future__ import annotations

import json
import re
from pathlib import Path

from graspdsl.report.agreement import QUANTITIES
from graspdsl.report.drawing import SMALL, Drawing, panels_of
from graspdsl.report.engines import METHODS, Engines, agreement_tables, outcomes_table, runs_table, said_of
from graspdsl.report.palette import LIGHT, series
from graspdsl.report.summary import plain
from graspdsl.report.templating import rendered
from graspdsl.report.writing import replace

PAGE, NUMBERS, FIGURE = "engines.html", "engines.json", "agreement"
CAPTION = (
    "How far pairs of trials that both converged differ, over the tolerance: the median with its 95 % interval, and "
    "the largest as a ring. Left of the line they agree."
)


def agreement_figure(found: Engines) -> Drawing:
    """Differences of each quantity over its tolerance, a line for each run that is held against another."""
    height = 0.6 + len(QUANTITIES) * (0.35 + 0.17 * len(found.against))
    figure, panels = panels_of(height, [1.0] * len(QUANTITIES))
    for rank, (axes, (name, quantity)) in enumerate(zip(panels, QUANTITIES.items(), strict=True)):
        colour = LIGHT[series(rank)]
        for place, pair in enumerate(found.against):
            one = pair.quantities[name]
            if one.typical is None or one.largest is None:
                continue
            low, high = (end / one.tolerance for end in one.interval or (one.typical, one.typical))
            axes.plot([low, high], [place, place], color=colour, linewidth=2.0, solid_capstyle="butt")
            axes.plot(one.typical / one.tolerance, place, "o", color=colour, markersize=4)
            axes.plot(one.largest / one.tolerance, place, "o", color=colour, markersize=4, fillstyle="none")
        axes.axvline(1.0, color=LIGHT["muted"], linewidth=0.7)
        axes.set_xscale("symlog", linthresh=1.0)
        axes.set_xlim(0.0, None)
        axes.xaxis.set_major_formatter("{x:g}")
        axes.set_ylim(len(found.against) - 0.5, -0.5)
        axes.set_yticks(range(len(found.against)), [found.runs[pair.run].label for pair in found.against])
        for tick in axes.get_yticklabels():
            tick.set_parse_math(False)
        label = re.sub(r"ρ_(\w)", r"ρ$_\1$", quantity.label)
        axes.set_title(f"{label}: 1 is {quantity.bound}", fontsize=SMALL, color=LIGHT["ink"], loc="left")
    panels[-1].set_xlabel("difference over tolerance (1)")
    return Drawing(FIGURE, figure, CAPTION)


def write_engines(place: Path, found: Engines) -> Path:
    """Write page, figure and numbers into a folder.

    Returns where the page is. Raises DiagnosticError where the folder cannot be written to.
    """
    drawing = agreement_figure(found)
    page = rendered(
        "engines.html",
        found=found,
        said=said_of(found),
        tables=[runs_table(found), *agreement_tables(found), outcomes_table(found)],
        commands=[run.command for run in found.runs],
        figures=[drawing],
        methods=METHODS,
    )
    data = json.dumps(plain(found), indent=2, ensure_ascii=False, allow_nan=False) + "\n"
    replace(place, {PAGE: page, NUMBERS: data, **drawing.files()})
    return place / PAGE
