"""The figures of a run's page, each with what it says to the reader."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from matplotlib.figure import Figure

from graspdsl.arrays import Array
from graspdsl.report.attraction import map_of_run
from graspdsl.report.drawing import svg_of
from graspdsl.report.evidence import Evidence
from graspdsl.report.figures import Draws, Funnel, convergence_figure, funnel_figure, residual_figure, starts_figure
from graspdsl.report.map_figure import map_figure
from graspdsl.report.palette import series
from graspdsl.report.statistics import Band, band, bandwidth
from graspdsl.report.summary import Summary
from graspdsl.report.wording import counted

MILLIMETRES = 1000.0  # in a metre


@dataclass(frozen=True, slots=True)
class Drawing:
    """A figure with its name, which is that of its files too, its caption, and itself as an SVG file."""

    name: str
    figure: Figure
    caption: str
    svg: str


def drawing(name: str, figure: Figure, caption: str) -> Drawing:
    """A figure, drawn."""
    return Drawing(name, figure, caption, svg_of(figure, name))


def tick_of(evidence: Evidence) -> str:
    """What a row of a course is: what happens once for each."""
    return "probes" if evidence.program.probes else "controller ticks"


def drawn_funnel(evidence: Evidence, summary: Summary) -> Drawing | None:
    """Where grasps started and ended; None where no grasp had an orientation."""
    before = _angles(summary.orientation_start)
    touched = np.array([bool(touching) for touching in summary.in_contact_end], dtype=bool)
    after = np.where(touched, _angles(summary.orientation_end), math.nan)
    if not (np.isfinite(before).any() or np.isfinite(after).any()):
        return None
    ranks = {number: rank for rank, mode in enumerate(summary.modes) for number in mode.trials}
    of_trial = [ranks.get(record.number, -1) for record in evidence.records]
    centres = [mode.centre for mode in summary.modes]
    widths = [f"{bandwidth(known):.3f} rad" for known in (before[np.isfinite(before)], after[np.isfinite(after)])]
    caption = (
        "Orientation of the grasp against the object's axis, before the controller (above) and at the end (below); a "
        "line joins the two of a trial, in the colour of its mode; × is a trial that does not count at the end. "
        "Curves: densities by a Gaussian kernel, reflected at 0 and π/2, "
        f"bandwidth {widths[0]} before and {widths[1]} after; ticks on the axes: single trials; vertical lines: modes."
    )
    return drawing("funnel", funnel_figure(Funnel(before, after, of_trial, centres)), caption)


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
        drawing(
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
    return drawing("convergence", convergence_figure(np.array(ticks, dtype=float), finished, tick=tick), caption)


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
    return drawing("map", map_figure(made), caption)


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
    return drawing("starts", starts_figure(draws), caption)


def _angles(values: Sequence[float | None]) -> Array:
    return np.array([math.nan if value is None else value for value in values], dtype=float)


def _curves(evidence: Evidence, members: Sequence[int]) -> tuple[Band, Band] | None:
    """The bands of ‖ρ_f‖ (1) and ‖ρ_m‖ [mm] of trials; None where none was measured."""
    courses = [evidence.courses[number] for number in members if number in evidence.courses]
    force, moment = band([course.force for course in courses]), band([MILLIMETRES * c.moment for c in courses])
    return None if force is None or moment is None else (force, moment)
