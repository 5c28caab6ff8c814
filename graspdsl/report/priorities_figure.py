"""How far each level that others are subject to was disturbed over time, drawn."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from graspdsl.arrays import Array, Rows
from graspdsl.report.drawing import Drawing, panels_of
from graspdsl.report.evidence import Evidence
from graspdsl.report.palette import LIGHT, series
from graspdsl.report.priorities import Priorities, scale_of
from graspdsl.report.statistics import MOST_TICKS

DISTURBED = (5.0, 50.0, 95.0)  # percentiles


def drawn_priorities(evidence: Evidence, priorities: Priorities) -> Drawing | None:
    """How far each level was disturbed over time; None where none was."""
    each = "probes" if evidence.program.probes else "controller ticks"
    curves = []
    for level in priorities.certified:
        seen = [course.disturbed(level.stage, level.place) for course in evidence.courses.values()]
        if curve := _curve([one for one in seen if np.isfinite(one).any()]):
            curves.append((level, *curve))
    if not curves:
        return None
    figure, panels = panels_of(0.6 + 1.5 * len(curves), [1.0] * len(curves))
    for rank, (axes, (level, ticks, quantiles, most)) in enumerate(zip(panels, curves, strict=True)):
        colour = LIGHT[series(rank)]
        unit, scale = scale_of(level.observed.unit)
        low, middle, high = scale * quantiles
        axes.fill_between(ticks, low, high, color=colour, alpha=0.2, linewidth=0)
        axes.plot(ticks, middle, color=colour, linewidth=1.4)
        axes.plot(ticks, scale * most, color=LIGHT["muted"], linewidth=0.7)
        axes.set_yscale("log")
        axes.set_ylabel(f"{level.name} ({unit or '1'})", parse_math=False)
        axes.set_xlim(0.0, max(1.0, float(ticks[-1])))
    panels[-1].set_xlabel(f"{each} since the controller took over")
    figure.align_ylabels()
    caption = (
        "How far what each level senses went from where it alone would have taken it by its Jacobian, in one step, of "
        "trials still running. Line: median; band: 5th to 95th percentile; thin line: the largest. Logarithmic."
    )
    return Drawing("priorities", figure, caption)


def _curve(seen: Sequence[Array]) -> tuple[Rows, Array, Array] | None:
    """Ticks (t,) at which any trial tells of a level, the percentiles (3, t) over trials, and the largest (t,)."""
    if not seen:
        return None
    together = np.full((len(seen), max(map(len, seen))), np.nan)
    for row, one in zip(together, seen, strict=True):
        row[: len(one)] = one
    known = np.flatnonzero(np.isfinite(together).any(axis=0))
    if len(known) > MOST_TICKS:
        known = known[np.linspace(0, len(known) - 1, MOST_TICKS).astype(int)]
    chosen = together[:, known]
    quantiles = np.asarray(np.nanpercentile(chosen, DISTURBED, axis=0))
    return known, quantiles, np.asarray(np.nanmax(chosen, axis=0))
