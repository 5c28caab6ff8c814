"""A comparison as files: its figures, its numbers, and one page that holds all of it.

The figures show what several runs did, over one another, each run in a colour of its own.
"""

from __future__ import annotations

import json
import math
import textwrap
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from graspdsl.arrays import Array
from graspdsl.report.comparison import Comparison, comparison_tables, methods_of
from graspdsl.report.drawing import SMALL, Drawing, over_orientations, panels_of
from graspdsl.report.evidence import Evidence
from graspdsl.report.palette import LIGHT, series
from graspdsl.report.sameness import said_of
from graspdsl.report.statistics import ORIENTATIONS, Band, band, bandwidth, density
from graspdsl.report.summary import plain
from graspdsl.report.templating import rendered
from graspdsl.report.writing import prepare
from graspdsl.trials.store import RunFolder

LONGEST_LABEL = 70  # characters
PAGE, NUMBERS = "compare.html", "compare.json"
STEPS = 400  # points in time that a mean is drawn through
FAR = 20.0  # times: runs whose lengths differ by more are drawn over a logarithm
DASHES: Sequence[tuple[int, Sequence[float]]] = ((0, ()), (0, (5, 2)), (0, (1.5, 1.5)), (0, (5, 1.5, 1, 1.5)))


@dataclass(frozen=True, slots=True)
class Side:
    """One of the runs that are compared: what a legend calls it, and what is known of it."""

    label: str
    evidence: Evidence


def orientation_figure(sides: Sequence[Side]) -> Figure:
    """Densities of the orientations in which trials settled, one over the other."""
    figure, (axes,) = panels_of(2.9, (1.0,))
    for place, side in enumerate(sides):
        touching = filter(side.evidence.touching, side.evidence.records)
        ends = np.array([record.orientation_end for record in touching if record.outcome.settled], dtype=float)
        known = ends[np.isfinite(ends)]
        heights = density(known, ORIENTATIONS, bandwidth(known)) if len(known) else np.full_like(ORIENTATIONS, math.nan)
        _line(axes, place, ORIENTATIONS, heights, f"{side.label}, {len(known)} settled")
        if len(known):
            axes.fill_between(ORIENTATIONS, heights, color=LIGHT[series(place)], alpha=0.10, linewidth=0)
    axes.set_ylim(0.0, None)
    axes.set_ylabel("density (1/rad)")
    over_orientations(axes, "orientation of the grasp at the end (rad)")
    _legend(figure, axes)
    return figure


def residual_figure(sides: Sequence[Side]) -> Figure:
    """Mean residuals over time since the controllers took over, with the 10th to 90th percentiles of trials.

    A trial that has ended keeps its last residuals. ‖ρ_f‖ above (1), ‖ρ_m‖ below [mm].
    """
    figure, (above, below) = panels_of(4.6, (1.0, 1.0))
    longest = [_longest(side.evidence) for side in sides]
    known = [length for length in longest if length > 0.0]
    for place, (side, length) in enumerate(zip(sides, longest, strict=True)):
        for axes, name, scale in ((above, "force", 1.0), (below, "moment", 1000.0)):
            found = _band(side.evidence, name, length)
            if found is None:
                _line(axes, place, np.zeros(0), np.zeros(0), f"{side.label}, no trial")
                continue
            times = found.ticks * length / (STEPS - 1)
            colour = LIGHT[series(place)]
            axes.fill_between(times, scale * found.low, scale * found.high, color=colour, alpha=0.12, linewidth=0)
            _line(axes, place, times, scale * found.mean, f"{side.label}, {int(found.running[0])} trials")
    if known and max(known) > FAR * min(known):
        below.set_xscale("symlog", linthresh=min(known) / 10, linscale=0.5)
    below.set_xlim(0.0, max(known, default=1.0))
    for axes, label in ((above, "force residual ‖ρ$_f$‖ (1)"), (below, "moment residual ‖ρ$_m$‖ (mm)")):
        axes.set_ylim(0.0, None)
        axes.set_ylabel(label)
    below.set_xlabel("time since the controller took over (s)")
    figure.align_ylabels()
    _legend(figure, above)
    return figure


def convergence_figure(sides: Sequence[Side]) -> Figure:
    """The share of each run's finished trials that have converged within so many ticks or probes."""
    figure, (axes,) = panels_of(2.9, (1.0,))
    found = [_ticks(side.evidence) for side in sides]
    latest = [float(ticks[-1]) for ticks in found if len(ticks)]
    end = 1.05 * max(latest, default=1.0)
    for place, (side, ticks) in enumerate(zip(sides, found, strict=True)):
        finished = len(side.evidence.records)
        at = np.concatenate([[0.0], ticks, [end]])
        share = 100.0 * np.concatenate([[0.0], np.arange(1, len(ticks) + 1), [len(ticks)]]) / max(1, finished)
        _line(axes, place, at, share, f"{side.label}, {len(ticks)} of {finished}", steps=True)
    if latest and max(latest) > FAR * max(1.0, min(latest)):
        axes.set_xscale("symlog", linthresh=max(1.0, min(latest) / 10), linscale=0.5)
    axes.set_xlim(0.0, end)
    axes.set_ylim(0.0, 105.0)
    axes.set_yticks([0, 25, 50, 75, 100])
    axes.set_ylabel("trials converged (%)")
    axes.set_xlabel("ticks or probes to converge")
    _legend(figure, axes)
    return figure


def _ticks(evidence: Evidence) -> Array:
    found = [record.ticks_to_converge for record in evidence.records]
    return np.array(sorted(ticks for ticks in found if ticks is not None), dtype=float)


def _longest(evidence: Evidence) -> float:
    return max((float(course.time[-1]) for course in evidence.courses.values() if len(course.time)), default=0.0)


def _band(evidence: Evidence, name: str, longest: float) -> Band | None:
    """The band of a residual, its ticks STEPS points in time from 0 to ``longest`` [s]."""
    times = np.linspace(0.0, longest, STEPS)
    courses = []
    for course in evidence.courses.values():
        if len(course.time):
            latest = np.searchsorted(course.time, times, side="right") - 1
            courses.append(np.asarray(getattr(course, name)[latest], dtype=float))
    return band(courses)


def _line(axes: Axes, place: int, x: Array, y: Array, label: str, *, steps: bool = False) -> None:
    axes.plot(
        x,
        y,
        color=LIGHT[series(place)],
        linestyle=DASHES[place % len(DASHES)],
        linewidth=1.6,
        label=label,
        drawstyle="steps-post" if steps else "default",
    )


def _legend(figure: Figure, axes: Axes) -> None:
    handles, labels = axes.get_legend_handles_labels()
    made = figure.legend(
        handles, labels, loc="outside upper left", frameon=False, fontsize=SMALL, labelcolor=LIGHT["ink"], ncols=1
    )
    for text in made.get_texts():
        text.set_parse_math(False)


FIGURES: Mapping[str, tuple[Callable[[Sequence[Side]], Figure], str]] = {
    "orientation": (
        orientation_figure,
        "Densities of the orientation of grasps at the end of each run's trials, over those that settled with all "
        "contacts touching.",
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
    drawings = [Drawing(name, draw(sides), caption) for name, (draw, caption) in FIGURES.items()]
    for drawing in drawings:
        files |= drawing.files()
    files[PAGE] = page(found, drawings)
    prepare(place, files)


def _label(number: int, folder: RunFolder) -> str:
    whole = ", ".join([f"{number}: {folder.manifest.name}", *folder.manifest.settings])
    return textwrap.shorten(whole, LONGEST_LABEL, placeholder=" …")


def page(found: Comparison, figures: Sequence[Drawing]) -> str:
    """The page of a comparison: one file that needs no other."""
    return rendered(
        "compare.html",
        runs=found.runs,
        said=said_of(found.sameness),
        tables=comparison_tables(found),
        methods=methods_of(found),
        figures=figures,
    )
