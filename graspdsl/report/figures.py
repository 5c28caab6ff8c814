"""The figures of a run's page, each with what it says to the reader, in the colours of light ground."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from graspdsl.arrays import Array
from graspdsl.report.attraction import map_of_run
from graspdsl.report.drawing import MEDIUM, ORIENTATIONS, SMALL, Drawing, over_orientations, panels_of
from graspdsl.report.evidence import Evidence
from graspdsl.report.map_figure import map_figure
from graspdsl.report.palette import LIGHT, series
from graspdsl.report.statistics import RIGHT_ANGLE, Band, band, bandwidth, density
from graspdsl.report.summary import Summary
from graspdsl.report.wording import counted

MILLIMETRES = 1000.0  # in a metre
START_BINS = 24
MOST_PATHS = 400  # lines from start to end that a figure can still show


def tick_of(evidence: Evidence) -> str:
    """What a row of a course is: what happens once for each."""
    return "probes" if evidence.program.probes else "controller ticks"


def drawn_funnel(evidence: Evidence, summary: Summary) -> Drawing | None:
    """Where grasps started and ended; None where no grasp had an orientation."""
    before = _angles(summary.orientation_start)
    touched = np.array([bool(touching) for touching in summary.in_contact_end], dtype=bool)
    settled = np.array([record.outcome.settled for record in evidence.records], dtype=bool)
    ends = np.where(touched, _angles(summary.orientation_end), math.nan)
    after, stopped = np.where(settled, ends, math.nan), np.where(settled, math.nan, ends)
    if not (np.isfinite(before).any() or np.isfinite(ends).any()):
        return None
    ranks = {number: rank for rank, mode in enumerate(summary.modes) for number in mode.trials}
    of_trial = [ranks.get(record.number, -1) for record in evidence.records]
    centres = [mode.centre for mode in summary.modes]
    widths = [f"{bandwidth(known):.3f} rad" for known in (before[np.isfinite(before)], after[np.isfinite(after)])]
    caption = (
        "Orientation of the grasp against the object's axis, before the controller (above) and at the end (below); a "
        "line joins the two of a trial, in the colour of its mode, or in grey and dashed where a monitor stopped it "
        "before it settled: such a trial is in no mode and not in the density; × is one that ended with a contact off. "
        "Curves: densities by a Gaussian kernel, reflected at 0 and π/2, "
        f"bandwidth {widths[0]} before and {widths[1]} after; ticks on the axes: single trials; vertical lines: modes."
    )
    return Drawing("funnel", funnel_figure(Funnel(before, after, stopped, of_trial, centres)), caption)


def drawn_residuals(evidence: Evidence, summary: Summary) -> list[Drawing]:
    """How residuals fell, for each mode, and for the trials that ended in none."""
    groups: list[tuple[str, str, str, Sequence[int]]] = [
        (f"residuals-mode-{rank}", f"Mode {rank}, {mode.centre:.2f} rad", series(rank - 1), mode.trials)
        for rank, mode in enumerate(summary.modes, 1)
    ]
    within = {number for *_, members in groups for number in members}
    others = [record.number for record in evidence.records if record.number not in within]
    groups.append(("residuals-others", "Trials in no mode" if within else "All trials", "before", others))
    found = []
    for name, title, colour, members in groups:
        curves = _curves(evidence, members)
        if curves is not None:
            found.append((name, title, colour, *curves))
    tops = [np.array([force.high.max(), moment.high.max()]) for *_, force, moment in found]
    top = 1.08 * np.max(tops, axis=0) if tops else np.ones(2)
    until, tick = evidence.program.spec.program[-1].until, tick_of(evidence)
    moment_bound = None if until.moment_residual is None else MILLIMETRES * until.moment_residual
    return [
        Drawing(
            name,
            residual_figure(
                force,
                moment,
                colour,
                tick=tick,
                bounds=(until.force_residual, moment_bound),
                top=np.where(top > 0.0, top, 1.0),
            ),
            f"{title}: {counted(int(force.running[0]), 'trial', 'trials')}. Line: mean over trials; band: 10th to 90th "
            "percentile; below: how many trials were still running. A trial that has ended keeps its last residuals."
            + (" Dashed: what the end condition asks for." if until.force_residual or until.moment_residual else ""),
        )
        for name, title, colour, force, moment in found
    ]


def drawn_convergence(evidence: Evidence) -> Drawing | None:
    """How soon trials converged; None where none did."""
    ticks = [record.ticks_to_converge for record in evidence.records if record.ticks_to_converge is not None]
    if not ticks:
        return None
    tick, finished = tick_of(evidence), len(evidence.records)
    caption = (
        f"The share of all {counted(finished, 'finished trial', 'finished trials')} that had converged after so many "
        f"{tick}: from then on the end conditions held. Dashed: the share in the end."
    )
    return Drawing("convergence", convergence_figure(np.array(ticks, dtype=float), finished, tick=tick), caption)


def drawn_map(evidence: Evidence) -> Drawing | None:
    """Which starts of a grid ended where; None for a run that is no finished grid of two axes."""
    grid = evidence.program.spec.trials.grid or ()
    cells = math.prod(axis.cells for axis in grid)
    if len(grid) != 2 or not len(evidence.records) == evidence.folder.manifest.asked == cells:
        return None
    made = map_of_run(evidence.folder)
    caption = (
        "The starts on the run's grid, by how they ended; converged cells by the orientation they ended in, "
        f"and how many {made.tick} they took."
    )
    return Drawing("map", map_figure(made), caption)


def drawn_starts(evidence: Evidence, summary: Summary) -> Drawing | None:
    """What became of the draws of a start; None where every draw began a trial, or nothing differs between them."""
    kept = [record.start for record in evidence.records if record.start]
    rejected = [start.drawn for record in evidence.records for start in record.rejected]
    names = [name for name in summary.starts.parameters if all(name in start for start in rejected)]
    if not names or not rejected:
        return None
    draws = [
        Draws(
            f"{name} ({summary.starts.parameters[name].unit or 'rad or m'})",
            np.array([start[name] for start in kept]),
            np.array([start[name] for start in rejected]),
        )
        for name in names
    ]
    caption = (
        f"Draws of a start: dark the {len(kept)} that trials began with, light the {len(rejected)} that could not be "
        "taken up. A draw that cannot be taken up is placed anew with the same orientation, so that an orientation "
        "that is hard to take up is drawn more often."
    )
    return Drawing("starts", starts_figure(draws), caption)


def _angles(values: Sequence[float | None]) -> Array:
    return np.array([math.nan if value is None else value for value in values], dtype=float)


def _curves(evidence: Evidence, members: Sequence[int]) -> tuple[Band, Band] | None:
    """The bands of ‖ρ_f‖ (1) and ‖ρ_m‖ [mm] of trials; None where none was measured."""
    courses = [evidence.courses[number] for number in members if number in evidence.courses]
    force, moment = band([course.force for course in courses]), band([MILLIMETRES * c.moment for c in courses])
    return None if force is None or moment is None else (force, moment)


@dataclass(frozen=True, slots=True)
class Funnel:
    """Orientations [rad] before and after, or where a monitor stopped the trial, (n,) each by trial, NaN for those that
    do not count; ``mode``: the mode each trial ended in, by rank from 0, −1 for none; ``centres``: the peaks [rad] of
    the modes by rank."""

    before: Array
    after: Array
    stopped: Array
    mode: Sequence[int]
    centres: Sequence[float]


def funnel_figure(funnel: Funnel) -> Figure:
    """Densities of orientation before and after, and the way of each trial from the one to the other."""
    figure, (above, between, below) = panels_of(5.0, (1.5, 1.15, 1.5))
    before, after = funnel.before[np.isfinite(funnel.before)], funnel.after[np.isfinite(funnel.after)]
    _density(above, before, "before", "before the controller")
    above.tick_params(axis="x", length=0)  # only the rug, which they would look like
    _ways(between, funnel)
    _density(below, after, "ink", "settled after it")
    _rug_of_stopped(below, funnel.stopped[np.isfinite(funnel.stopped)])
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
    over_orientations(below, "orientation of the grasp against the object's axis (rad)")
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


def _density(axes: Axes, values: Array, colour: str, label: str) -> None:
    axes.set_ylabel("density (1/rad)")
    axes.set_title(
        f"{label}, {counted(len(values), 'trial', 'trials')}", loc="left", fontsize=MEDIUM, color=LIGHT["ink"]
    )
    if len(values):
        heights = density(values, ORIENTATIONS, bandwidth(values))
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
