"""How far each level that others are subject to was disturbed over time, drawn."""

from __future__ import annotations

from graspdsl.report.drawing import Drawing, panels_of
from graspdsl.report.figure_data import Disturbances
from graspdsl.report.palette import LIGHT, series


def drawn_priorities(found: Disturbances) -> Drawing:
    """How far each level was disturbed over time."""
    levels = found.levels
    figure, panels = panels_of(0.6 + 1.5 * len(levels), [1.0] * len(levels))
    for rank, (axes, level) in enumerate(zip(panels, levels, strict=True)):
        colour = LIGHT[series(rank)]
        low, middle, high = level.quantiles
        axes.fill_between(level.ticks, low, high, color=colour, alpha=0.2, linewidth=0)
        axes.plot(level.ticks, middle, color=colour, linewidth=1.4)
        axes.plot(level.ticks, level.most, color=LIGHT["muted"], linewidth=0.7)
        axes.set_yscale("log")
        axes.set_ylabel(f"{level.level} ({level.unit or '1'})", parse_math=False)
        axes.set_xlim(0.0, max(1.0, float(level.ticks[-1])))
    panels[-1].set_xlabel(f"{found.tick} since the controller took over")
    figure.align_ylabels()
    caption = (
        "How far what each level senses went from where it alone would have taken it by its Jacobian, in one step, of "
        "trials still running. Line: median; band: 5th to 95th percentile; thin line: the largest. Logarithmic."
    )
    return Drawing(found.name, figure, caption)
