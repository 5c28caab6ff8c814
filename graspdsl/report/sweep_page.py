"""A sweep as a page: its tables, and a figure for each field that is swept."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from graspdsl.places.fields import is_number
from graspdsl.places.wording import Data
from graspdsl.report.drawing import Drawing, legend_above, panels_of
from graspdsl.report.page import write_page
from graspdsl.report.palette import LIGHT, SERIES, series
from graspdsl.report.statistics import RIGHT_ANGLE, Interval
from graspdsl.report.sweeps import (
    METHODS,
    SweepSummary,
    SweptPoint,
    changes_tables,
    correlations_table,
    figure_name,
    labels_of,
    points_table,
    said,
    valued,
    verdict,
)
from graspdsl.report.templating import rendered
from graspdsl.spec.sweeping import settings
from graspdsl.trials.store import RunFolder

FAR = 30.0  # times: values that lie farther apart are drawn over a logarithm
BESIDE, WIDEST = 0.01, 0.06  # of the abscissa between lines at a value, and between the first and the last of many


def drawings_of_sweep(found: SweepSummary) -> list[Drawing]:
    """A figure for each field that is swept."""
    return [Drawing(figure_name(field), field_figure(found, field), _caption(found, field)) for field in found.fields]


def _caption(found: SweepSummary, field: str) -> str:
    lines = "" if len(found.fields) == 1 else ", a line for each combination of the other fields"
    lines = lines if found.on_grid else ", a mark for each point"
    return (
        f"Over {labels_of(list(found.fields))[field]}{lines}: the share of trials that converged and the ticks that "
        "they took, with 95 % intervals of shares and medians, and the orientation of grasps at the end: its "
        "median, thick bars from the 25th to the 75th percentile of trials, thin ones from the 10th to the 90th."
    )


@dataclass(frozen=True, slots=True)
class _Line:
    """Points to be joined, or not; what a legend calls them."""

    label: str
    points: list[SweptPoint]


def _lines(found: SweepSummary, field: str) -> list[_Line]:
    """The points that differ in a field alone together; of a sweep that is no grid, all of them."""
    if not found.on_grid:
        return [_Line("", list(found.points))]
    labels, lines = labels_of(list(found.fields)), dict[tuple[str, ...], list[SweptPoint]]()
    for point in found.points:
        others = {name: value for name, value in point.values.items() if name != field}
        lines.setdefault(settings(others), []).append(point)
    return [_Line(valued(points[0], labels, but=field), points) for points in lines.values()]


def field_figure(found: SweepSummary, field: str) -> Figure:
    """Over the values of a field, the share of trials that converged (%), the median ticks of those that did, and the
    orientation of grasps at the end [rad]: on a grid a line for every combination of the other fields."""
    figure, panels = panels_of(5.8, (1.0, 1.0, 1.0))
    place, lines = _placing(found, field, panels[-1]), _lines(found, field)
    told = len(lines) <= len(SERIES)
    for rank, line in enumerate(lines):
        colour = LIGHT[series(rank) if told else "before"]
        aside = (rank - (len(lines) - 1) / 2) * min(BESIDE, WIDEST / len(lines))
        begun = [(place(point.values[field], aside), point) for point in line.points if point.finished]
        known = sorted(begun, key=lambda placed: placed[0])
        drawn = _Drawn(colour, line.label, joined=found.on_grid)
        drawn.medians(panels[0], [(x, point.share, point.interval) for x, point in known], 100.0)
        name = "ticks_to_converge"
        drawn.medians(panels[1], [(x, point.medians[name], point.intervals[name]) for x, point in known])
        drawn.quantiles(panels[2], [(x, point.orientations) for x, point in known])
    panels[0].set_ylim(-4.0, 104.0)
    panels[0].set_ylabel("converged (%)")
    panels[1].set_ylim(0.0, None)
    panels[1].set_ylabel("ticks to converge")
    panels[2].set_ylim(0.0, RIGHT_ANGLE * 1.04)
    panels[2].set_ylabel("orientation at\nthe end (rad)")
    unit = found.fields[field]
    panels[2].set_xlabel(f"{field} ({unit})" if unit else field, parse_math=False)
    if told and len(lines) > 1:
        legend_above(figure, panels[0], columns=2)
    figure.align_ylabels()
    return figure


def _placing(found: SweepSummary, field: str, axes: Axes) -> Callable[[Data, float], float]:
    """Where values of a field are on the abscissa, so far aside [of its length]: numbers where they are, words one
    beside the other."""
    values = {said(point.values[field]): point.values[field] for point in found.points}
    if all(map(is_number, values.values())):
        numbers = list(map(_number, values.values()))
        low, high = min(numbers), max(numbers)
        if low > 0.0 and high > FAR * low:
            axes.set_xscale("log")
            return lambda value, aside: _number(value) * (high / low) ** aside
        return lambda value, aside: _number(value) + (high - low) * aside
    places = {name: float(place) for place, name in enumerate(values)}
    axes.set_xticks(list(places.values()), list(places), rotation=0 if len(places) < 8 else 60)
    axes.set_xlim(-0.5, len(places) - 0.5)
    for tick in axes.get_xticklabels():
        tick.set_parse_math(False)
    return lambda value, aside: places[said(value)] + len(places) * aside


def _number(value: Data) -> float:
    assert isinstance(value, int | float)
    return float(value)


@dataclass(frozen=True, slots=True)
class _Drawn:
    """A line of a figure: in which colour, under which name, and whether its marks are joined."""

    colour: str
    label: str
    joined: bool

    def medians(
        self, axes: Axes, known: Sequence[tuple[float, float | None, Interval | None]], scale: float = 1.0
    ) -> None:
        """Numbers with their intervals over places, times ``scale``."""
        marks = [(place, scale * value) for place, value, _ in known if value is not None]
        axes.plot(
            *(list(part) for part in zip(*marks, strict=True)),
            color=self.colour,
            label=self.label,
            marker="o",
            markersize=4.0,
            linewidth=1.2,
            linestyle="-" if self.joined else "none",
        )
        for place, _, interval in known:
            if interval is not None:
                self._bar(axes, place, scale * interval[0], scale * interval[1], 1.0)

    def quantiles(self, axes: Axes, known: Sequence[tuple[float, tuple[float, ...] | None]]) -> None:
        """Medians with bars over the middle half and the middle four fifths."""
        self.medians(axes, [(place, found[2] if found else None, None) for place, found in known])
        for place, found in known:
            if found is not None:
                self._bar(axes, place, found[0], found[4], 0.8)
                self._bar(axes, place, found[1], found[3], 2.4)

    def _bar(self, axes: Axes, place: float, low: float, high: float, width: float) -> None:
        axes.plot([place, place], [low, high], color=self.colour, linewidth=width, alpha=0.7)


def write_sweep(folder: RunFolder, found: SweepSummary) -> Path:
    """Write the page of a sweep and its figures into its folder, as :func:`graspdsl.report.page.write_report`."""
    drawings, differences = drawings_of_sweep(found), changes_tables(found)
    page = rendered(
        "sweep.html",
        found=found,
        verdict=verdict(found),
        spec_text=folder.spec_text,
        overrides=folder.manifest.overrides,
        points=points_table(found),
        fields=[
            (field, drawing, differences.get(field)) for field, drawing in zip(found.fields, drawings, strict=True)
        ],
        differences=differences.get(""),
        correlations=correlations_table(found),
        methods=METHODS,
    )
    return write_page(folder.path, page, drawings)
