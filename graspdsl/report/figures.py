"""The figures of a report: functions from data to figures, in the colours of light ground."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from graspdsl.arrays import Array
from graspdsl.report.palette import LIGHT, series
from graspdsl.report.statistics import RIGHT_ANGLE, Band, bandwidth, density

WIDTH = 5.4  # in
SMALL, MEDIUM = 8.0, 8.8  # pt
START_BINS = 24
MOST_PATHS = 400  # lines from start to end that a figure can still show
_GRID = np.linspace(0.0, RIGHT_ANGLE, 257)
_TURNS = (0.0, 0.2, 0.4, 0.6, 0.8, 1.0, 1.2, 1.4, RIGHT_ANGLE)
_TURN_LABELS = (*(f"{turn:g}" for turn in _TURNS[:-1]), "π/2")


@dataclass(frozen=True, slots=True)
class Funnel:
    """Orientations [rad] before and after, (n,) each by trial, NaN for those that do not count; ``mode``: the mode each
    trial ended in, by rank from 0, −1 for none; ``centres``: the peaks [rad] of the modes by rank."""

    before: Array
    after: Array
    mode: Sequence[int]
    centres: Sequence[float]


def funnel_figure(funnel: Funnel) -> Figure:
    """Densities of orientation before and after, and the way of each trial from the one to the other."""
    figure, (above, between, below) = panels_of(5.0, (1.5, 1.15, 1.5))
    before, after = funnel.before[np.isfinite(funnel.before)], funnel.after[np.isfinite(funnel.after)]
    _density(above, before, "before", "before the controller")
    above.tick_params(axis="x", length=0)  # only the rug, which they would look like
    _ways(between, funnel)
    _density(below, after, "ink", "after it")
    if len(after):
        peaks = density(after, np.asarray(funnel.centres), bandwidth(after))
        for rank, (centre, peak) in enumerate(zip(funnel.centres, peaks, strict=True)):
            colour = LIGHT[series(rank)]
            below.plot([centre, centre], [0.0, peak], color=colour, linewidth=1.4)
            toward, side = (-4, "right") if centre > 0.5 * RIGHT_ANGLE else (4, "left")
            below.annotate(
                f"mode {rank + 1}",
                (centre, peak),
                (toward, 1),
                textcoords="offset points",
                ha=side,
                va="bottom",
                color=colour,
                fontsize=SMALL,
                fontweight="bold",
                annotation_clip=False,
            )
    below.set_xlim(0.0, RIGHT_ANGLE)
    below.set_xticks(_TURNS, _TURN_LABELS)
    below.set_xlabel("orientation of the grasp against the object's axis (rad)")
    return figure


def residual_figure(
    force: Band, moment: Band, colour: str, *, tick: str, bounds: tuple[float | None, float | None], top: Array
) -> Figure:
    """Residuals by tick or probe (``tick``), ‖ρ_f‖ above (1) and ‖ρ_m‖ below [mm], and how many trials still ran.

    bounds: what the end conditions ask of each; top (2,): the upper ends of the axes, so that figures compare.
    """
    figure, panels = panels_of(5.0, (1.6, 1.6, 0.5))
    labels = ("force residual ‖ρ$_f$‖ (1)", "moment residual ‖ρ$_m$‖ (mm)")
    for axes, curve, label, bound, most in zip(panels, (force, moment), labels, bounds, top, strict=False):
        axes.fill_between(curve.ticks, curve.low, curve.high, color=LIGHT[colour], alpha=0.2, linewidth=0)
        axes.plot(curve.ticks, curve.mean, color=LIGHT[colour], linewidth=1.6)
        axes.set_ylabel(label)
        axes.set_ylim(0.0, float(most))
        if bound is not None and bound < most:
            axes.axhline(bound, color=LIGHT["muted"], linewidth=0.9, linestyle=(0, (4, 3)))
            axes.annotate(
                f"bound {bound:g}",
                (1.0, bound),
                (-2, 2),
                xycoords=axes.get_yaxis_transform(),
                textcoords="offset points",
                ha="right",
                color=LIGHT["muted"],
                fontsize=SMALL,
            )
    running, count = panels[-1], float(force.running[0])
    running.fill_between(force.ticks, force.running, step="post", color=LIGHT["before"], alpha=0.35, linewidth=0)
    running.step(force.ticks, force.running, where="post", color=LIGHT["before"], linewidth=1.0)
    running.set_ylim(0.0, 1.15 * count)
    running.set_yticks([0.0, count])
    running.set_ylabel("running")
    running.set_xlabel(f"{tick} since the controller took over")
    running.set_xlim(0.0, max(1.0, float(force.ticks[-1])))
    figure.align_ylabels()
    return figure


def convergence_figure(ticks: Array, finished: int, *, tick: str) -> Figure:
    """The share of ``finished`` trials that have converged within so many ticks or probes; ticks (n,), one for each
    trial that did."""
    figure, (axes,) = panels_of(2.5, (1.0,))
    ordered = np.sort(ticks)
    longest = 1.08 * float(ordered[-1]) or 1.0
    at = np.concatenate([[0.0], ordered, [longest]])
    share = 100.0 * np.concatenate([[0.0], np.arange(1, len(ordered) + 1), [len(ordered)]]) / finished
    axes.fill_between(at, share, step="post", color=LIGHT["series-1"], alpha=0.15, linewidth=0)
    axes.step(at, share, where="post", color=LIGHT["series-1"], linewidth=1.6)
    axes.axhline(share[-1], color=LIGHT["muted"], linewidth=0.9, linestyle=(0, (4, 3)))
    axes.set_xlim(0.0, longest)
    axes.set_ylim(0.0, 105.0)
    axes.set_yticks([0, 25, 50, 75, 100])
    axes.set_ylabel("trials converged (%)")
    axes.set_xlabel(f"{tick} since the controller took over")
    return figure


@dataclass(frozen=True, slots=True)
class Draws:
    """A number of the starts that were drawn: its name with its unit, the values that trials began with (n,), and those
    of draws that could not be taken up (m,)."""

    label: str
    kept: Array
    rejected: Array


def starts_figure(draws: Sequence[Draws]) -> Figure:
    """How many draws of each number of a start began a trial, and how many could not be taken up."""
    figure, panels = panels_of(1.5 * len(draws), [1.0] * len(draws), shared=False)
    for axes, drawn in zip(panels, draws, strict=True):
        edges = np.histogram_bin_edges(np.concatenate([drawn.kept, drawn.rejected]), START_BINS)
        colours = [LIGHT["series-1"], LIGHT["faint"]]
        axes.hist([drawn.kept, drawn.rejected], edges.tolist(), stacked=True, color=colours)
        axes.set_xlabel(drawn.label)
        axes.set_ylabel("draws")
    return figure


def panels_of(height: float, ratios: Sequence[float], *, shared: bool = True) -> tuple[Figure, list[Axes]]:
    """A figure and its panels, one above the other over the same abscissa, or each over its own."""
    figure = Figure((WIDTH, height), layout="constrained", facecolor=LIGHT["ground"])
    panels = list(
        figure.subplots(len(ratios), 1, sharex=shared, squeeze=False, gridspec_kw={"height_ratios": ratios})[:, 0]
    )
    for axes in panels:
        axes.set_facecolor("none")
        axes.spines[["top", "right"]].set_visible(False)
        axes.spines[["left", "bottom"]].set(color=LIGHT["muted"], linewidth=0.7)
        axes.tick_params(colors=LIGHT["muted"], labelsize=SMALL, width=0.7, length=3)
        axes.xaxis.label.set(color=LIGHT["ink"], fontsize=MEDIUM)
        axes.yaxis.label.set(color=LIGHT["ink"], fontsize=MEDIUM)
    return figure, panels


def _density(axes: Axes, values: Array, colour: str, label: str) -> None:
    axes.set_ylabel("density (1/rad)")
    axes.set_title(f"{label}, {len(values)} trials", loc="left", fontsize=MEDIUM, color=LIGHT["ink"])
    if len(values):
        heights = density(values, _GRID, bandwidth(values))
        axes.fill_between(_GRID, heights, color=LIGHT[colour], alpha=0.16, linewidth=0)
        axes.plot(_GRID, heights, color=LIGHT[colour], linewidth=1.4)
        axes.plot(values, np.zeros_like(values), "|", color=LIGHT[colour], markersize=7, markeredgewidth=0.9,
                  clip_on=False)  # fmt: skip
        axes.set_ylim(0.0, 1.12 * float(heights.max()))
    else:
        axes.set_yticks([])


def _ways(axes: Axes, funnel: Funnel) -> None:
    """A line for each trial from its orientation before to that after; grey and open for one that ended in no mode."""
    chosen = np.unique(np.linspace(0, len(funnel.mode) - 1, min(len(funnel.mode), MOST_PATHS)).astype(int))
    for trial in chosen:
        before, after, rank = funnel.before[trial], funnel.after[trial], funnel.mode[trial]
        if math.isfinite(before) and math.isfinite(after):
            colour = LIGHT[series(rank)]
            axes.plot([before, after], [1.0, 0.0], color=colour, linewidth=0.9, alpha=0.75)
        elif math.isfinite(before):
            axes.plot([before], [1.0], "x", color=LIGHT["before"], markersize=4.5, clip_on=False)
    axes.set_ylim(-0.04, 1.04)
    axes.set_yticks([1.0, 0.0], ["before", "after"])
    axes.spines[["left", "bottom"]].set_visible(False)
    axes.tick_params(length=0)
