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
from graspdsl.report.data_files import CSV, Columns, files_of
from graspdsl.report.drawing import Drawing, legend_above, over_orientations, panels_of
from graspdsl.report.evidence import Evidence
from graspdsl.report.figure_data import MILLIMETRES, Convergence, Density, convergence_of
from graspdsl.report.palette import LIGHT, series
from graspdsl.report.sameness import said_of
from graspdsl.report.statistics import ORIENTATIONS, Band, band
from graspdsl.report.summary import plain
from graspdsl.report.templating import rendered
from graspdsl.report.writing import prepare
from graspdsl.trials.columns import Column
from graspdsl.trials.store import RunFolder

LONGEST_LABEL = 70  # characters
PAGE, NUMBERS = "compare.html", "compare.json"
STEPS = 400  # points in time that a mean is drawn through
FAR = 20.0  # times: runs whose lengths differ by more are drawn over a logarithm
DASHES: Sequence[tuple[int, Sequence[float]]] = ((0, ()), (0, (5, 2)), (0, (1.5, 1.5)), (0, (5, 1.5, 1, 1.5)))


@dataclass(frozen=True, slots=True)
class Side:
    """What figures draw of one of the runs that are compared: what a legend calls it, the orientations in which trials
    ``settled``, its residuals over time up to ``longest`` [s], ‖ρ_f‖ (1) and ‖ρ_m‖ [mm], None where none was measured,
    and how soon trials ``converged``."""

    label: str
    settled: Density
    longest: float
    force: Band | None
    moment: Band | None
    converged: Convergence

    @classmethod
    def of(cls, label: str, evidence: Evidence) -> Side:
        """Of what is known of a run."""
        touching = filter(evidence.touching, evidence.records)
        ends = np.array([record.orientation_end for record in touching if record.outcome.settled], dtype=float)
        longest = _longest(evidence)
        force, moment = (_band(evidence, *of, longest) for of in (("force", 1.0), ("moment", MILLIMETRES)))
        return cls(label, Density(ends[np.isfinite(ends)]), longest, force, moment, convergence_of(evidence))

    def times(self, curve: Band) -> Array:
        """When a residual has the values of a curve [s]."""
        return curve.ticks * self.longest / (STEPS - 1)


def orientation_figure(sides: Sequence[Side]) -> Figure:
    """Densities of the orientations in which trials settled, one over the other."""
    figure, (axes,) = panels_of(2.9, (1.0,))
    for place, side in enumerate(sides):
        heights, count = side.settled.heights, len(side.settled.values)
        drawn = heights if count else np.full_like(ORIENTATIONS, math.nan)
        _line(axes, place, ORIENTATIONS, drawn, f"{side.label}, {count} settled")
        if count:
            axes.fill_between(ORIENTATIONS, heights, color=LIGHT[series(place)], alpha=0.10, linewidth=0)
    axes.set_ylim(0.0, None)
    axes.set_ylabel("density (1/rad)")
    over_orientations(axes, "orientation of the grasp at the end (rad)")
    legend_above(figure, axes)
    return figure


def residual_figure(sides: Sequence[Side]) -> Figure:
    """Mean residuals over time since the controllers took over, with the 10th to 90th percentiles of trials.

    A trial that has ended keeps its last residuals. ‖ρ_f‖ above (1), ‖ρ_m‖ below [mm].
    """
    figure, (above, below) = panels_of(4.6, (1.0, 1.0))
    known = [side.longest for side in sides if side.longest > 0.0]
    for place, side in enumerate(sides):
        for axes, found in ((above, side.force), (below, side.moment)):
            if found is None:
                _line(axes, place, np.zeros(0), np.zeros(0), f"{side.label}, no trial")
                continue
            colour = LIGHT[series(place)]
            axes.fill_between(side.times(found), found.low, found.high, color=colour, alpha=0.12, linewidth=0)
            _line(axes, place, side.times(found), found.mean, f"{side.label}, {int(found.running[0])} trials")
    if known and max(known) > FAR * min(known):
        below.set_xscale("symlog", linthresh=min(known) / 10, linscale=0.5)
    below.set_xlim(0.0, max(known, default=1.0))
    for axes, label in ((above, "force residual ‖ρ$_f$‖ (1)"), (below, "moment residual ‖ρ$_m$‖ (mm)")):
        axes.set_ylim(0.0, None)
        axes.set_ylabel(label)
    below.set_xlabel("time since the controller took over (s)")
    figure.align_ylabels()
    legend_above(figure, above)
    return figure


def convergence_figure(sides: Sequence[Side]) -> Figure:
    """The share of each run's finished trials that have converged within so many ticks or probes."""
    figure, (axes,) = panels_of(2.9, (1.0,))
    latest = [float(side.converged.ticks[-1]) for side in sides if len(side.converged.ticks)]
    end = 1.05 * max(latest, default=1.0)
    for place, side in enumerate(sides):
        ticks, shares = side.converged.ticks, side.converged.shares
        at = np.concatenate([[0.0], ticks, [end]])
        share = 100.0 * np.concatenate([[0.0], shares, shares[-1:] if len(shares) else [0.0]])
        _line(axes, place, at, share, f"{side.label}, {len(ticks)} of {side.converged.finished}", steps=True)
    if latest and max(latest) > FAR * max(1.0, min(latest)):
        axes.set_xscale("symlog", linthresh=max(1.0, min(latest) / 10), linscale=0.5)
    axes.set_xlim(0.0, end)
    axes.set_ylim(0.0, 105.0)
    axes.set_yticks([0, 25, 50, 75, 100])
    axes.set_ylabel("trials converged (%)")
    axes.set_xlabel("ticks or probes to converge")
    legend_above(figure, axes)
    return figure


def orientation_columns(side: Side) -> Columns:
    """The density of one run."""
    heights = side.settled.heights
    return {
        "orientation": Column(ORIENTATIONS[: len(heights)], "rad"),
        "density": Column(heights, "1/rad"),
        "bandwidth": Column(np.full(len(heights), side.settled.width), "rad"),
    }


def residual_columns(side: Side) -> Columns:
    """The curves of one run."""
    known = side.force or side.moment
    found = {"time": Column(side.times(known) if known else np.zeros(0), "s")}
    for name, unit, curve in (("force", "1", side.force), ("moment", "mm", side.moment)):
        for what, values in zip(("mean", "p10", "p90"), _curves(curve, len(found["time"].values)), strict=True):
            found[f"{name}_residual.{what}"] = Column(values, unit)
    return found


def _curves(found: Band | None, count: int) -> tuple[Array, Array, Array]:
    nothing = np.full(count, math.nan)
    return (found.mean, found.low, found.high) if found else (nothing, nothing, nothing)


def convergence_columns(side: Side) -> Columns:
    """The steps of one run."""
    return {"tick": Column(side.converged.ticks, "1"), "share": Column(side.converged.shares, "1")}


def _one_below_the_other(sides: Sequence[Side], of: Callable[[Side], Columns]) -> Columns:
    """The columns of each run, with the number of the run and what a legend calls it."""
    parts = [of(side) for side in sides]
    rows = [len(next(iter(part.values())).values) for part in parts]
    return {
        "run": Column(np.repeat(np.arange(1, len(sides) + 1), rows), "1"),
        "label": Column(np.repeat([side.label for side in sides], rows), ""),
        **{
            name: Column(np.concatenate([part[name].values for part in parts]), column.unit)
            for name, column in parts[0].items()
        },
    }


def _longest(evidence: Evidence) -> float:
    return max((float(course.time[-1]) for course in evidence.courses.values() if len(course.time)), default=0.0)


def _band(evidence: Evidence, name: str, scale: float, longest: float) -> Band | None:
    """The band of a residual, scaled, its ticks STEPS points in time from 0 to ``longest`` [s]."""
    times = np.linspace(0.0, longest, STEPS)
    courses = []
    for course in evidence.courses.values():
        if len(course.time):
            latest = np.searchsorted(course.time, times, side="right") - 1
            courses.append(scale * np.asarray(getattr(course, name)[latest], dtype=float))
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


FIGURES: Mapping[str, tuple[Callable[[Sequence[Side]], Figure], Callable[[Side], Columns], str]] = {
    "orientation": (
        orientation_figure,
        orientation_columns,
        "Densities of the orientation of grasps at the end of each run's trials, over those that settled with all "
        "contacts touching.",
    ),
    "residuals": (
        residual_figure,
        residual_columns,
        "Residuals since the controller took over: the mean over trials, and the band from their 10th to their 90th "
        "percentile. A trial that has ended keeps its last residuals; a curve ends with its run's longest trial.",
    ),
    "convergence": (
        convergence_figure,
        convergence_columns,
        "The share of each run's finished trials that have converged within so many ticks, or probes where contacts "
        "are displaced by probing.",
    ),
}


def write_comparison(place: Path, evidences: Sequence[Evidence], found: Comparison) -> None:
    """Write the figures and what they draw, the numbers and the page of a comparison into an empty or new folder.

    Raises DiagnosticError where it cannot.
    """
    sides = [Side.of(_label(number, evidence.folder), evidence) for number, evidence in enumerate(evidences, 1)]
    files: dict[str, str | bytes] = {NUMBERS: json.dumps(plain(found), indent=2, allow_nan=False) + "\n"}
    drawings = []
    for name, (draw, columns, caption) in FIGURES.items():
        drawings.append(Drawing(name, draw(sides), caption))
        files |= drawings[-1].files() | files_of(f"{name}.{CSV}", _one_below_the_other(sides, columns), CSV)
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
