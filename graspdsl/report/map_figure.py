"""The figure of a map: cells by class, and by how many ticks they took; and the files of both."""

from __future__ import annotations

import json
import textwrap
from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import PolyCollection
from matplotlib.colors import ListedColormap
from matplotlib.figure import Figure
from matplotlib.patches import Patch

from graspdsl.arrays import Array
from graspdsl.report.attraction import FILES, AttractionMap, CellClass, as_data
from graspdsl.report.drawing import MEDIUM, SMALL, Sheet, png_of, svg_of
from graspdsl.report.palette import LIGHT, series
from graspdsl.report.wording import counted, percent
from graspdsl.spec.outcomes import STROKES
from graspdsl.trials.maps import Axis, Cells
from graspdsl.trials.outcomes import OUTCOMES, Outcome

WIDTH, SIDE = 4.4, 3.3  # in, of a panel with its legend, and of its cells
LINE = 0.16  # in, of a legend
MOST_PATHS = 10_000  # cells that are drawn as shapes; more are a picture
NAMES = {"azimuth": "azimuth of {contact}", "polar": "polar angle of {contact} from the top"}
STROKE = "#aab2bb"


def map_files(made: AttractionMap) -> dict[str, str | bytes]:
    """A map's figure and numbers, by the names of their files."""
    figure = map_figure(made)
    contents = (svg_of(figure, "map"), png_of(figure), json.dumps(as_data(made), allow_nan=False) + "\n")
    return dict(zip(FILES, contents, strict=True))


def map_figure(made: AttractionMap) -> Figure:
    """Which starts end where, and beside it how many ticks or probes those took that converged, if any did."""
    cells, some = made.cells, bool(np.isfinite(made.cells.ticks).any())
    count = 2 if some else 1
    heading = textwrap.wrap(_heading(made), 68 * count)
    height = SIDE + 0.9 + LINE * (len(made.classes) + 2 + len(heading))
    figure = Sheet((WIDTH * count, height), layout="constrained", facecolor=LIGHT["ground"])
    figure.suptitle("\n".join(heading), x=0.01, ha="left", fontsize=SMALL, color=LIGHT["muted"], parse_math=False)
    panels = list(figure.subplots(1, count, squeeze=False)[0])
    for axes in panels:
        _frame(axes, cells)
    _classes(panels[0], made)
    if some:
        _ticks(figure, panels[1], made)
    return figure


def _heading(made: AttractionMap) -> str:
    fixed = "; ".join(f"{name} {value}" for name, value in made.cells.fixed.items() if name != "contact")
    return f"{made.name}, seed {made.seed}. Fixed: {fixed}." if fixed else f"{made.name}, seed {made.seed}."


def axis_label(axis: Axis, cells: Cells) -> str:
    """What an axis is of, with its unit."""
    name = NAMES.get(axis.parameter, axis.parameter).format_map(cells.fixed)
    return f"{name} ({axis.unit})"


def style_of(found: CellClass) -> tuple[str, str]:
    """The colour and the hatching of a class of cells.

    What converged is in colour, what did not in grey: told apart with every kind of colour vision.
    """
    if found.outcome == Outcome.CONVERGED.value:
        return LIGHT[series((found.mode or 1) - 1)], ""
    outcome = OUTCOMES[found.outcome]
    return outcome.grey, outcome.hatching


def _frame(axes: Axes, cells: Cells) -> None:
    axes.set_xlim(cells.x.low, cells.x.high)
    axes.set_ylim(*((cells.y.high, cells.y.low) if cells.y.parameter == "polar" else (cells.y.low, cells.y.high)))
    axes.set_box_aspect(1.0)
    axes.set_xlabel(axis_label(cells.x, cells), fontsize=MEDIUM, color=LIGHT["ink"], parse_math=False)
    axes.set_ylabel(axis_label(cells.y, cells), fontsize=MEDIUM, color=LIGHT["ink"], parse_math=False)
    axes.spines[:].set(color=LIGHT["muted"], linewidth=0.7)
    axes.tick_params(colors=LIGHT["muted"], labelsize=SMALL, width=0.7, length=3)
    for name, (x, y) in cells.marks.items():
        axes.plot([x], [y], "+", color=LIGHT["ink"], markersize=9, markeredgewidth=2.6, zorder=5)
        axes.plot([x], [y], "+", color=LIGHT["ground"], markersize=8, markeredgewidth=1.2, zorder=6)
        axes.annotate(
            name,
            (x, y),
            (4, 4),
            textcoords="offset points",
            color=LIGHT["ink"],
            fontsize=SMALL,
            annotation_clip=True,
            parse_math=False,
            zorder=6,
            bbox={"boxstyle": "round,pad=0.15", "facecolor": LIGHT["ground"], "edgecolor": "none", "alpha": 0.8},
        )


def _classes(axes: Axes, made: AttractionMap) -> None:
    cells, total = made.cells, len(made.cells.outcomes)
    place = np.zeros(total)
    for index, found in enumerate(made.classes):
        place[list(found.cells)] = index
    styles = [style_of(found) for found in made.classes]
    axes.pcolormesh(
        cells.x.edges,
        cells.y.edges,
        place.reshape(cells.y.cells, cells.x.cells),
        cmap=ListedColormap([colour for colour, _ in styles]),
        vmin=-0.5,
        vmax=len(styles) - 0.5,
        rasterized=total > MOST_PATHS,
    )
    for found, (_, hatch) in zip(made.classes, styles, strict=True):
        if hatch:
            shapes = PolyCollection(
                _corners(cells, found.cells),
                facecolors="none",
                edgecolors=STROKE if hatch == STROKES else LIGHT["muted"],
                linewidths=0.0,
                hatch=hatch,
                rasterized=total > MOST_PATHS,
            )
            axes.add_collection(shapes)
    handles = [
        Patch(facecolor=colour, hatch=hatch, edgecolor=STROKE, linewidth=0.6, label=_entry(found))
        for found, (colour, hatch) in zip(made.classes, styles, strict=True)
    ]
    axes.set_title("where each start ends", loc="left", fontsize=MEDIUM, color=LIGHT["ink"])
    axes.legend(
        handles=handles,
        loc="upper left",
        bbox_to_anchor=(0.0, -0.17),
        frameon=False,
        fontsize=SMALL,
        labelcolor=LIGHT["ink"],
        borderaxespad=0.0,
        borderpad=0.0,
        handlelength=1.4,
        title="share of cells (95 % interval)",
        title_fontsize=SMALL,
        alignment="left",
    )


def _entry(found: CellClass) -> str:
    cells = counted(len(found.cells), "cell", "cells")
    low, high = found.interval
    return f"{found.label}: {cells}, {percent(found.share)} ({100 * low:.0f} to {percent(high)})"


def _ticks(figure: Figure, axes: Axes, made: AttractionMap) -> None:
    cells = made.cells
    axes.set_facecolor(LIGHT["faint"])
    mesh = axes.pcolormesh(
        cells.x.edges,
        cells.y.edges,
        np.ma.masked_invalid(cells.ticks.reshape(cells.y.cells, cells.x.cells)),
        cmap="cividis",
        rasterized=len(cells.ticks) > MOST_PATHS,
    )
    bar = figure.colorbar(mesh, ax=axes, shrink=0.8)
    bar.outline.set_linewidth(0.0)
    bar.ax.tick_params(colors=LIGHT["muted"], labelsize=SMALL, width=0.7, length=3)
    axes.set_title(f"{made.tick} to converge", loc="left", fontsize=MEDIUM, color=LIGHT["ink"])


def _corners(cells: Cells, chosen: Sequence[int]) -> list[Array]:
    across, up = cells.x.edges, cells.y.edges
    shapes = []
    for cell in chosen:
        row, column = divmod(cell, cells.x.cells)
        left, right, low, high = across[column], across[column + 1], up[row], up[row + 1]
        shapes.append(np.array([[left, low], [right, low], [right, high], [left, high]]))
    return shapes
