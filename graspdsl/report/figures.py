"""The figures of a run's page, each with what it says to the reader, in the colours of light ground."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from graspdsl.arrays import Array
from graspdsl.report.drawing import MEDIUM, SMALL, Drawing, over_orientations, panels_of
from graspdsl.report.figure_data import (
    Convergence,
    Density,
    Disturbances,
    Draws,
    FigureData,
    Funnel,
    ResidualCurves,
    StartDraws,
    StartMap,
)
from graspdsl.report.map_figure import map_figure
from graspdsl.report.palette import LIGHT, series
from graspdsl.report.priorities_figure import drawn_priorities
from graspdsl.report.statistics import ORIENTATIONS, RIGHT_ANGLE
from graspdsl.report.wording import counted

MOST_PATHS = 400  # lines from start to end that a figure can still show


def drawing_of(figure: FigureData) -> Drawing:
    """A figure, drawn."""
    match figure:
        case Funnel():
            return drawn_funnel(figure)
        case ResidualCurves():
            return _drawn_residuals(figure)
        case Convergence():
            return _drawn_convergence(figure)
        case StartMap():
            return _drawn_map(figure)
        case StartDraws():
            return _drawn_starts(figure)
        case Disturbances():
            return drawn_priorities(figure)


def drawn_funnel(funnel: Funnel) -> Drawing:
    """Where grasps started and ended."""
    widths = [f"{one.width:.3f} rad" for one in funnel.densities]
    caption = (
        "Orientation of the grasp against the object's axis, before the controller (above) and at the end (below); a "
        "line joins the two of a trial, in the colour of its mode, or in grey and dashed where a monitor stopped it "
        "before it settled: such a trial is in no mode and not in the density; × is one that ended with a contact off. "
        "Curves: densities by a Gaussian kernel, reflected at 0 and π/2, "
        f"bandwidth {widths[0]} before and {widths[1]} after; ticks on the axes: single trials; vertical lines: modes."
    )
    return Drawing(funnel.name, funnel_figure(funnel), caption)


def _drawn_residuals(curves: ResidualCurves) -> Drawing:
    caption = (
        f"{curves.title}: {counted(int(curves.force.running[0]), 'trial', 'trials')}. Line: mean over trials; band: "
        "10th to 90th percentile; below: how many trials were still running. A trial that has ended keeps its last "
        "residuals." + (" Dashed: what the end condition asks for." if any(curves.bounds) else "")
    )
    return Drawing(curves.name, residual_figure(curves), caption)


def _drawn_convergence(found: Convergence) -> Drawing:
    caption = (
        f"The share of all {counted(found.finished, 'finished trial', 'finished trials')} that had converged after so "
        f"many {found.tick}: from then on the end conditions held. Dashed: the share in the end."
    )
    return Drawing(found.name, convergence_figure(found), caption)


def _drawn_map(found: StartMap) -> Drawing:
    caption = (
        "The starts on the run's grid, by how they ended; converged cells by the orientation they ended in, "
        f"and how many {found.made.tick} they took."
    )
    return Drawing(found.name, map_figure(found.made), caption)


def _drawn_starts(found: StartDraws) -> Drawing:
    caption = (
        f"Draws of a start: dark the {found.kept} that trials began with, light the {found.rejected} that could not be "
        "taken up. A draw that cannot be taken up is placed anew with the same orientation, so that an orientation "
        "that is hard to take up is drawn more often."
    )
    return Drawing(found.name, starts_figure(found.draws), caption)


def funnel_figure(funnel: Funnel) -> Figure:
    """Densities of orientation before and after, and the way of each trial from the one to the other."""
    figure, (above, between, below) = panels_of(5.0, (1.5, 1.15, 1.5))
    before, after = funnel.densities
    _density(above, before, "before", "before the controller")
    above.tick_params(axis="x", length=0)  # only the rug, which they would look like
    _ways(between, funnel)
    _density(below, after, "ink", "settled after it")
    _rug_of_stopped(below, funnel.stopped[np.isfinite(funnel.stopped)])
    for rank, (centre, peak) in enumerate(zip(funnel.centres, funnel.peaks, strict=False)):
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
    over_orientations(below, "orientation of the grasp against the object's axis (rad)")
    return figure


def residual_figure(curves: ResidualCurves) -> Figure:
    """Residuals by tick or probe, ‖ρ_f‖ above (1) and ‖ρ_m‖ below [mm], and how many trials still ran."""
    figure, panels = panels_of(5.0, (1.6, 1.6, 0.5))
    colour, force = LIGHT["before" if curves.rank is None else series(curves.rank)], curves.force
    labels = ("force residual ‖ρ$_f$‖ (1)", "moment residual ‖ρ$_m$‖ (mm)")
    for axes, curve, label, bound, most in zip(
        panels, (force, curves.moment), labels, curves.bounds, curves.top, strict=False
    ):
        axes.fill_between(curve.ticks, curve.low, curve.high, color=colour, alpha=0.2, linewidth=0)
        axes.plot(curve.ticks, curve.mean, color=colour, linewidth=1.6)
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
    running.set_xlabel(f"{curves.tick} since the controller took over")
    running.set_xlim(0.0, max(1.0, float(force.ticks[-1])))
    figure.align_ylabels()
    return figure


def convergence_figure(found: Convergence) -> Figure:
    """The share of finished trials that have converged within so many ticks or probes."""
    figure, (axes,) = panels_of(2.5, (1.0,))
    longest = 1.08 * float(found.ticks[-1]) or 1.0
    at = np.concatenate([[0.0], found.ticks, [longest]])
    share = 100.0 * np.concatenate([[0.0], found.shares, found.shares[-1:]])
    axes.fill_between(at, share, step="post", color=LIGHT["series-1"], alpha=0.15, linewidth=0)
    axes.step(at, share, where="post", color=LIGHT["series-1"], linewidth=1.6)
    axes.axhline(share[-1], color=LIGHT["muted"], linewidth=0.9, linestyle=(0, (4, 3)))
    axes.set_xlim(0.0, longest)
    axes.set_ylim(0.0, 105.0)
    axes.set_yticks([0, 25, 50, 75, 100])
    axes.set_ylabel("trials converged (%)")
    axes.set_xlabel(f"{found.tick} since the controller took over")
    return figure


def starts_figure(draws: Sequence[Draws]) -> Figure:
    """How many draws of each number of a start began a trial, and how many could not be taken up."""
    figure, panels = panels_of(1.5 * len(draws), [1.0] * len(draws), shared=False)
    for axes, drawn in zip(panels, draws, strict=True):
        edges, counts = drawn.edges.tolist(), [drawn.kept, drawn.rejected]
        colours = [LIGHT["series-1"], LIGHT["faint"]]
        axes.hist([edges[:-1]] * 2, edges, weights=counts, stacked=True, color=colours)
        axes.set_xlabel(drawn.label)
        axes.set_ylabel("draws")
    return figure


def _density(axes: Axes, found: Density, colour: str, label: str) -> None:
    values, heights = found.values, found.heights
    axes.set_ylabel("density (1/rad)")
    axes.set_title(
        f"{label}, {counted(len(values), 'trial', 'trials')}", loc="left", fontsize=MEDIUM, color=LIGHT["ink"]
    )
    if len(values):
        axes.fill_between(ORIENTATIONS, heights, color=LIGHT[colour], alpha=0.16, linewidth=0)
        axes.plot(ORIENTATIONS, heights, color=LIGHT[colour], linewidth=1.4)
        axes.plot(values, np.zeros_like(values), "|", color=LIGHT[colour], markersize=7, markeredgewidth=0.9,
                  clip_on=False)  # fmt: skip
        axes.set_ylim(0.0, 1.12 * float(heights.max()))
    else:
        axes.set_yticks([])


def _rug_of_stopped(axes: Axes, values: Array) -> None:
    """Single trials that a monitor stopped, in grey above the density of those that settled."""
    if len(values):
        axes.plot(values, np.ones_like(values), "|", color=LIGHT["before"], markersize=7, markeredgewidth=0.9,
                  transform=axes.get_xaxis_transform(), clip_on=False)  # fmt: skip
        said = f"| stopped by a monitor, {counted(len(values), 'trial', 'trials')}"
        axes.set_title(said, loc="right", fontsize=MEDIUM, color=LIGHT["before"])


def _ways(axes: Axes, funnel: Funnel) -> None:
    """A line for each trial from its orientation before to that after, or to where it was stopped, in grey; a mark for
    one that counts in neither."""
    chosen = np.unique(np.linspace(0, len(funnel.mode) - 1, min(len(funnel.mode), MOST_PATHS)).astype(int))
    for trial in chosen:
        before, after, rank = funnel.before[trial], funnel.after[trial], funnel.mode[trial]
        if math.isfinite(before) and math.isfinite(after):
            colour = LIGHT[series(rank)]
            axes.plot([before, after], [1.0, 0.0], color=colour, linewidth=0.9, alpha=0.75)
        elif math.isfinite(before) and math.isfinite(funnel.stopped[trial]):
            axes.plot([before, funnel.stopped[trial]], [1.0, 0.0], color=LIGHT["before"], linewidth=0.9, alpha=0.75,
                      linestyle=(0, (4, 3)))  # fmt: skip
        elif math.isfinite(before):
            axes.plot([before], [1.0], "x", color=LIGHT["before"], markersize=4.5, clip_on=False)
    axes.set_ylim(-0.04, 1.04)
    axes.set_yticks([1.0, 0.0], ["before", "after"])
    axes.spines[["left", "bottom"]].set_visible(False)
    axes.tick_params(length=0)
