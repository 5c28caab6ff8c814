"""A sweep: what its points did, and what became of trials when one of its fields changed."""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np

from graspdsl.compiler.program import Program
from graspdsl.places.fields import is_number
from graspdsl.places.validation import slot
from graspdsl.places.wording import Data, as_yaml, shortened, slug
from graspdsl.report.comparison import MEASURES, Against, Measure, held_against, pairs_of
from graspdsl.report.data_files import Columns
from graspdsl.report.evidence import Evidence
from graspdsl.report.statistics import (
    Estimate,
    Interval,
    median,
    median_interval,
    rank_correlation,
    wilson,
)
from graspdsl.report.summary import repeating
from graspdsl.report.tables import COUNT, INTERVAL, SHARE, TEXT, Column, Format, Table, fixed
from graspdsl.report.wording import counted, percent, percents
from graspdsl.spec.models import Spec
from graspdsl.spec.sweeping import Point, Sweep, settings
from graspdsl.trials.columns import UNITS
from graspdsl.trials.columns import Column as DataColumn
from graspdsl.trials.outcomes import Outcome
from graspdsl.trials.store import RunFolder

MEASURED = {
    "ticks_to_converge": Measure("ticks to converge", 0, lambda r: float(r.ticks_to_converge or 0), every=False),
    **{name: MEASURES[name] for name in ("orientation_end", "force_residual_end", "moment_residual_end")},
}
SHOWN = tuple(MEASURED)
QUARTERS = (10.0, 25.0, 50.0, 75.0, 90.0)  # percentiles
METHODS = (
    "Intervals hold 95 %: of shares they are Wilson's, of medians between order statistics. Trials of the same number "
    "begin alike at all points where that can be, and are then compared pair by pair: differences of shares have "
    "Newcombe's score intervals, those of medians the bootstrap's. Each is by itself: of many, one in twenty misses."
)


@dataclass(frozen=True, slots=True)
class SweptPoint:
    """What the trials of one point did: ``values`` of the fields that are swept, and the median of each measure over
    those trials that have it, with an interval where there are enough; ``orientations``: the percentiles QUARTERS of
    the orientation at the end [rad]. ``run``: the folder that it is read from as a run."""

    number: int
    run: str
    values: Point
    asked: int
    finished: int
    converged: int
    share: float | None
    interval: Interval | None
    outcomes: Mapping[str, int]
    medians: Mapping[str, float | None]
    intervals: Mapping[str, Interval | None]
    orientations: tuple[float, ...] | None


@dataclass(frozen=True, slots=True)
class Change:
    """A point against one that differs from it in nothing but one field; in a sweep that is no grid, against the first
    point, which differs in all, and there is no one ``field``."""

    field: str | None
    point: int
    base: int
    against: Against


@dataclass(frozen=True, slots=True)
class Correlation:
    """How the numbers of a field and of a measure go together over the points, by their ranks (Spearman's ρ, 1)."""

    field: str
    measure: str
    estimate: Estimate


@dataclass(frozen=True, slots=True)
class SweepSummary:
    """Everything that is said of a sweep. ``fields``: what is swept, each with its unit, empty for words. ``on_grid``:
    whether its points are all combinations of values of them."""

    name: str
    run: str
    seed: int
    command: str
    on_grid: bool
    fields: Mapping[str, str]
    points: tuple[SweptPoint, ...]
    changes: tuple[Change, ...]
    correlations: tuple[Correlation, ...]

    @property
    def finished(self) -> int:
        """How many trials are finished, at all points."""
        return sum(point.finished for point in self.points)

    @property
    def converged(self) -> int:
        """How many of them converged."""
        return sum(point.converged for point in self.points)


def swept(folder: RunFolder, program: Program) -> SweepSummary:
    """What the trials of a sweep did that are finished. Raises DiagnosticError where they cannot be read."""
    assert program.spec.sweep is not None
    sweep, manifest = program.spec.sweep, folder.manifest
    values, numbered = sweep.points(), range(len(manifest.points))
    found = [_evidence(folder.at_point(number), program.at(number)) for number in numbered]
    points = tuple(_point(number, values[number], evidence) for number, evidence in enumerate(found))
    changes = tuple(
        Change(field, point, base, _against(found[base], found[point]))
        for field, point, base in _changes(sweep, values)
    )
    units = {field: _unit(field, [point[field] for point in values]) for field in sweep.fields}
    told = tuple(_correlations(units, points)) if sweep.random else ()
    what = manifest.name, str(folder.path), manifest.seed, repeating(folder), sweep.grid is not None
    return SweepSummary(*what, units, points, changes, told)


def _against(base: Evidence, point: Evidence) -> Against:
    return held_against(base, point, pairs_of(base, point), MEASURED)


def _evidence(folder: RunFolder, program: Program) -> Evidence:
    """The trials of a point, without their courses."""
    return Evidence(folder, program, tuple(folder.records()), {}, frozenset())


def _unit(field: str, values: Sequence[Data]) -> str:
    if not all(map(is_number, values)):
        return ""
    return slot(Spec, tuple(int(step) if step.isdecimal() else step for step in field.split("."))).unit or "1"


def _point(number: int, values: Point, evidence: Evidence) -> SweptPoint:
    records = evidence.records
    converged = sum(record.outcome is Outcome.CONVERGED for record in records)
    measured = {name: measure.values(records) for name, measure in MEASURED.items()}
    ends = measured["orientation_end"]
    return SweptPoint(
        *(number, str(evidence.folder.path), values, evidence.folder.manifest.asked, len(records), converged),
        share=converged / len(records) if records else None,
        interval=wilson(converged, len(records)) if records else None,
        outcomes=dict(Counter(record.outcome.value for record in records).most_common()),
        medians={name: median(found) for name, found in measured.items()},
        intervals={name: median_interval(found) for name, found in measured.items()},
        orientations=tuple(map(float, np.percentile(ends, QUARTERS))) if len(ends) else None,
    )


def _changes(sweep: Sweep, points: Sequence[Point]) -> list[tuple[str | None, int, int]]:
    """Which points are held against which: on a grid, for each field, those that have not its first value against the
    one that has it and is the same else."""
    if sweep.grid is None:
        return [(None, point, 0) for point in range(1, len(points))]
    by_values = {settings(point): number for number, point in enumerate(points)}
    found: list[tuple[str | None, int, int]] = []
    for field in sweep.fields:
        first = points[0][field]
        based = [by_values[settings({**point, field: first})] for point in points]
        found += [(field, number, base) for number, base in enumerate(based) if number != base]
    return found


def _correlations(units: Mapping[str, str], points: Sequence[SweptPoint]) -> list[Correlation]:
    """Of every field of numbers with the share that converged and with the median of every measure."""
    measures: dict[str, Callable[[SweptPoint], float | None]] = {"converged": lambda point: point.share}
    measures |= {name: _median_of(name) for name in SHOWN}
    found = []
    for field in (field for field, unit in units.items() if unit):
        for name, of in measures.items():
            rows = [(point.values[field], of(point)) for point in points]
            known = np.array([row for row in rows if row[1] is not None], dtype=float).reshape(-1, 2)
            if (estimate := rank_correlation(known[:, 0], known[:, 1])) is not None:
                found.append(Correlation(field, name, estimate))
    return found


def _median_of(name: str) -> Callable[[SweptPoint], float | None]:
    return lambda point: point.medians[name]


# Words


def verdict(found: SweepSummary) -> str:
    """How many trials converged over all, and at which points the least and the most."""
    if not found.finished:
        return "No trial has finished."
    known = [point for point in found.points if point.share is not None]
    low, high = (choose(known, key=lambda point: point.share or 0.0) for choose in (min, max))
    whole = f"{found.converged} of {counted(found.finished, 'trial', 'trials')} converged"
    whole += f" at {counted(len(found.points), 'point', 'points')}"
    if low.share == high.share:
        return f"{whole}, {percent(low.share)} at each."
    return f"{whole}: from {_at(low)} to {_at(high)}."


def _at(point: SweptPoint) -> str:
    assert point.interval is not None
    share = f"{percent(point.share)} ({percents(point.interval)})"
    return f"{share} at {valued(point, labels_of(list(point.values)))}"


def figure_name(field: str) -> str:
    """What the figure of a field is called."""
    return f"sweep-{slug(field)}"


# Data


def tables_of_sweep(found: SweepSummary) -> dict[str, Callable[[], Columns]]:
    """What a report of a sweep shows besides single trials, by name, with a row a point, a difference or a
    correlation."""
    made: dict[str, Callable[[], Columns]] = {"points": partial(_points, found)}
    made |= {"differences": partial(_differences, found)} if found.changes else {}
    made |= {"correlations": partial(_correlated, found)} if found.correlations else {}
    return made


def _points(found: SweepSummary) -> dict[str, DataColumn]:
    points = found.points
    made = {"point": _whole([point.number for point in points]), **_valued([point.values for point in points])}
    made |= {name: _whole([getattr(point, name) for point in points]) for name in ("asked", "finished", "converged")}
    made |= _ranged("share", "1", [(point.share, point.interval) for point in points])
    for name in SHOWN:
        made |= _ranged(name, UNITS[name], [(point.medians[name], point.intervals[name]) for point in points])
    for place, percentile in enumerate(QUARTERS):
        ends = [point.orientations[place] if point.orientations else None for point in points]
        made[f"orientation_end.p{percentile:.0f}"] = _numbers(ends, "rad")
    for outcome in dict.fromkeys(name for point in points for name in point.outcomes):
        made[f"outcomes.{outcome}"] = _whole([point.outcomes.get(outcome, 0) for point in points])
    return made


def _differences(found: SweepSummary) -> dict[str, DataColumn]:
    changes = found.changes
    made = {
        "field": _words([change.field or "" for change in changes]),
        "point": _whole([change.point for change in changes]),
        "against": _whole([change.base for change in changes]),
        "pairs": _whole([change.against.pairs for change in changes]),
        **_estimated("share", "1", [change.against.converged for change in changes]),
    }
    for name in SHOWN:
        made |= _estimated(name, UNITS[name], [change.against.differences.get(name) for change in changes])
    return made


def _correlated(found: SweepSummary) -> dict[str, DataColumn]:
    return {
        "field": _words([one.field for one in found.correlations]),
        "measure": _words([one.measure for one in found.correlations]),
        "points": _whole([one.estimate.count for one in found.correlations]),
        **_estimated("correlation", "1", [one.estimate for one in found.correlations]),
    }


def columns_over(points: Sequence[Point], trials: Sequence[Columns]) -> dict[str, DataColumn]:
    """The columns of the trials of each point as one table, with the point of each trial and its values first; what
    some points have not is NaN there, or empty."""
    counts = [len(next(iter(columns.values())).values) for columns in trials]
    of_trial = [point for point, count in enumerate(counts) for _ in range(count)]
    made = {"point": _whole(of_trial), **_valued([points[point] for point in of_trial])}
    for name in dict.fromkeys(name for columns in trials for name in columns):
        known = next(columns[name] for columns in trials if name in columns)
        words = known.values.dtype.kind == "U"
        parts = [
            columns[name].values if name in columns else np.full(count, "" if words else np.nan)
            for columns, count in zip(trials, counts, strict=True)
        ]
        made[name] = DataColumn(np.concatenate(parts), known.unit)
    return made


def _valued(points: Sequence[Point]) -> dict[str, DataColumn]:
    """The values of points by fields, as numbers where all are."""
    made = {}
    for field in dict.fromkeys(field for point in points for field in point):
        values = [point[field] for point in points]
        unit = _unit(field, values)
        words = [value if isinstance(value, str) else json.dumps(value, ensure_ascii=False) for value in values]
        made[field] = DataColumn(np.array(values, dtype=float), unit) if unit else _words(words)
    return made


def _estimated(name: str, unit: str, estimates: Sequence[Estimate | None]) -> dict[str, DataColumn]:
    return _ranged(name, unit, [(one.value, one.interval) if one else (None, None) for one in estimates])


def _ranged(name: str, unit: str, known: Sequence[tuple[float | None, Interval | None]]) -> dict[str, DataColumn]:
    return {
        name: _numbers([value for value, _ in known], unit),
        f"{name}.low": _numbers([interval[0] if interval else None for _, interval in known], unit),
        f"{name}.high": _numbers([interval[1] if interval else None for _, interval in known], unit),
    }


def _numbers(values: Sequence[float | None], unit: str) -> DataColumn:
    return DataColumn(np.array([np.nan if value is None else value for value in values], dtype=float), unit)


def _whole(values: Sequence[int]) -> DataColumn:
    return DataColumn(np.array(values, dtype=np.int64), "1")


def _words(values: Sequence[str]) -> DataColumn:
    return DataColumn(np.array(values, dtype=np.str_), "")


# Tables


def said(value: Data) -> str:
    """A value of a field, in few letters."""
    if isinstance(value, float):
        return f"{value:.4g}"
    if is_number(value) or isinstance(value, bool):
        return as_yaml(value)
    return shortened(value if isinstance(value, str) else json.dumps(value, ensure_ascii=False), 40)


def labels_of(fields: Sequence[str]) -> dict[str, str]:
    """Fields by as many of the last parts of their paths as tell them apart."""
    found = {}
    for field in fields:
        parts = field.split(".")
        for count in range(1, len(parts) + 1):
            found[field] = ".".join(parts[-count:])
            if sum((f".{other}").endswith(f".{found[field]}") for other in fields) == 1:
                break
    return found


def valued(point: SweptPoint, labels: Mapping[str, str], but: str | None = None) -> str:
    """The values of a point, but for those of a field, in few letters."""
    return ", ".join(f"{labels[field]} {said(value)}" for field, value in point.values.items() if field != but)


def points_table(found: SweepSummary, *, briefly: bool = False) -> Table:
    """What the trials of each point did; ``briefly``: no more than a terminal has room for."""
    labels = labels_of(list(found.fields))
    columns = (
        Column("point", COUNT),
        *(Column(labels[field], _format(unit)) for field, unit in found.fields.items()),
        Column("trials", COUNT),
        Column("converged", SHARE),
        Column("95 %", INTERVAL),
        *(Column(_LABELS[name], _FORMATS[name]) for name in SHOWN),
        Column("other outcomes", _OUTCOMES),
    )
    rows = tuple(
        (
            *(point.number, *point.values.values(), point.finished, point.share, point.interval),
            *(point.medians[name] for name in SHOWN),
            {name: count for name, count in point.outcomes.items() if name != Outcome.CONVERGED.value} or None,
        )
        for point in found.points
    )
    whole = Table("Points: shares that converged, and medians", columns, rows, "ticks: those to converge")
    return whole.first(len(columns) - len(SHOWN)) if briefly else whole


def changes_tables(found: SweepSummary, *, briefly: bool = False) -> dict[str, Table]:
    """What became of trials when a field changed, a table a field by its path; of a sweep that is no grid one, by an
    empty one. ``briefly``: no more than a terminal has room for."""
    tables = {}
    for field in dict.fromkeys(change.field for change in found.changes):
        changes = [change for change in found.changes if change.field == field]
        label = "the first point" if field is None else labels_of(list(found.fields))[field]
        columns = (
            Column("point", COUNT),
            *(() if field is None else (Column(f"{label}", _format(found.fields[field])),)),
            Column("against", COUNT),
            Column("pairs", COUNT),
            Column("converged", TEXT),
            *(Column(_LABELS[name], TEXT) for name in SHOWN),
        )
        rows = tuple(_change(change, found) for change in changes)
        title = f"Differences from {label}" if field is None else f"Differences with {label}, all else the same"
        whole = Table(title, columns, rows, "differences of shares and of medians, with 95 % intervals")
        tables[field or ""] = whole.first(len(columns) - len(SHOWN) + 1) if briefly else whole
    return tables


def _change(change: Change, found: SweepSummary) -> tuple[object, ...]:
    against = change.against
    value = () if change.field is None else (found.points[change.point].values[change.field],)
    return (
        *(change.point, *value, change.base, against.pairs),
        _difference(against.converged, 100.0, "+.0f", " points"),
        *(_difference(against.differences.get(name), *_SCALED[name]) for name in SHOWN),
    )


def _difference(estimate: Estimate | None, scale: float, form: str, unit: str = "") -> str | None:
    if estimate is None:
        return None
    value = f"{scale * estimate.value:{form}}{unit}"
    if estimate.interval is None:
        return f"{value} (too few)"
    low, high = (scale * end for end in estimate.interval)
    return f"{value}, {low:{form}} to {high:{form}}"


def correlations_table(found: SweepSummary) -> Table:
    """How fields and measures go together over points that were drawn."""
    labels = labels_of(list(found.fields))
    columns = (
        Column("field"),
        Column("with"),
        Column("rank correlation", fixed(2)),
        Column("95 %", _ENDS),
        Column("points", COUNT),
    )
    rows = tuple(
        (
            *(labels[one.field], "share converged" if one.measure == "converged" else _LABELS[one.measure]),
            *(one.estimate.value, one.estimate.interval, one.estimate.count),
        )
        for one in found.correlations
    )
    return Table("How the points' values and what was measured go together (Spearman's ρ)", columns, rows)


def _format(unit: str) -> Format:
    return Format(said, unit="" if unit == "1" else unit) if unit else Format(said, words=True)


_OUTCOMES = Format(lambda outcomes: ", ".join(f"{name} {count}" for name, count in outcomes.items()), words=True)
_ENDS = Format(lambda ends: f"{ends[0]:+.2f} to {ends[1]:+.2f}", lambda ends: float(ends[0]))
_LABELS = {
    "ticks_to_converge": "ticks",
    "orientation_end": "orientation",
    "force_residual_end": "‖ρ_f‖",
    "moment_residual_end": "‖ρ_m‖",
}
_FORMATS = {
    "ticks_to_converge": fixed(0),
    "orientation_end": fixed(3, "rad"),
    "force_residual_end": fixed(4),
    "moment_residual_end": fixed(2, "mm", 1e3),
}
_SCALED: Mapping[str, tuple[float, str, str]] = {
    "ticks_to_converge": (1.0, "+.0f", ""),
    "orientation_end": (1.0, "+.3f", " rad"),
    "force_residual_end": (1.0, "+.4f", ""),
    "moment_residual_end": (1e3, "+.2f", " mm"),
}
