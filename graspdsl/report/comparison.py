"""Runs side by side: what each did, which are the same, and differences from the first with intervals."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import combinations
from typing import Any

import numpy as np

from graspdsl.arrays import Array, Flags
from graspdsl.report.evidence import Evidence
from graspdsl.report.outcomes import OutcomeCount
from graspdsl.report.sameness import Pairs, Sameness, sameness_table, samenesses
from graspdsl.report.statistics import (
    Estimate,
    difference_of_medians,
    difference_of_paired_shares,
    difference_of_shares,
    median,
    ratio_of_medians,
)
from graspdsl.report.summary import Summary
from graspdsl.report.tables import TEXT, Column, Table, Value, fixed
from graspdsl.report.wording import NOTHING, STOPPED, percent, percents
from graspdsl.trials.outcomes import Outcome
from graspdsl.trials.record import TrialRecord


@dataclass(frozen=True, slots=True)
class Measure:
    """A number of a trial: ``of`` takes it from the record, NaN where it was not measured.

    ``digits`` after the point where it is shown. ``every``: of every finished trial, else only of converged ones.
    ``ratio``: whether it is a cost, which is compared by ratio as well.
    """

    label: str
    digits: int
    of: Callable[[TrialRecord], float]
    every: bool = True
    ratio: bool = False

    def counts(self, record: TrialRecord) -> bool:
        """Whether a trial has this measure."""
        return (self.every or record.outcome is Outcome.CONVERGED) and math.isfinite(self.of(record))

    def values(self, records: Sequence[TrialRecord]) -> Array:
        """The measure of the trials that have it."""
        return np.array([self.of(record) for record in records if self.counts(record)], dtype=float)

    def paired(self, pairs: Pairs) -> tuple[Array, Array]:
        """The measure of both trials of the pairs in which both have it."""
        both = [pair for pair in pairs if self.counts(pair[0]) and self.counts(pair[1])]
        rows = np.array([[self.of(a), self.of(b)] for a, b in both], dtype=float).reshape(-1, 2)
        return rows[:, 0], rows[:, 1]


MEASURES: Mapping[str, Measure] = {
    "world_s": Measure("time of a trial [s] *", 2, lambda r: r.world_s, every=False, ratio=True),
    "samples": Measure("tactile samples *", 0, lambda r: float(r.samples), every=False, ratio=True),
    "ticks": Measure("ticks or probes *", 0, lambda r: float(r.ticks), every=False, ratio=True),
    "orientation_end": Measure("orientation at the end [rad]", 3, lambda r: r.orientation_end),
    "force_residual_end": Measure("force residual at the end", 4, lambda r: r.force_residual_end),
    "moment_residual_end": Measure("moment residual at the end [m]", 5, lambda r: r.moment_residual_end),
    "object_shift": Measure("object moved [m]", 5, lambda r: r.object_shift),
    "point_error": Measure("error of sensed points, 95th percentile [m]", 5, lambda r: r.point_error[1]),
    "normal_error": Measure("error of sensed normals, 95th percentile [rad]", 3, lambda r: r.normal_error[1]),
}


@dataclass(frozen=True, slots=True)
class ComparedRun:
    """What one of the runs did: its summary, its settings, and the median of each of MEASURES, in its unit."""

    summary: Summary
    settings: tuple[str, ...]
    medians: Mapping[str, float | None]

    def as_data(self) -> dict[str, Any]:
        """Of its summary what is compared."""
        one = self.summary
        return {
            "name": one.name,
            "settings": self.settings,
            "run": one.run,
            "seed": one.seed,
            "command": one.command,
            "asked": one.asked,
            "finished": one.finished,
            "converged": one.count(Outcome.CONVERGED),
            "share": one.converged.share,
            "interval": one.converged.interval,
            "outcomes": {
                entry.outcome: {"count": entry.count, "share": entry.share, "interval": entry.interval}
                for entry in one.outcome_table
            },
            "modes": [
                {"centre": mode.centre, "share": mode.share, "interval": mode.interval, "count": len(mode.trials)}
                for mode in one.modes
            ],
            "stopped": {"share": one.stopped.share, "interval": one.stopped.interval, "count": len(one.stopped.trials)},
            "medians": self.medians,
        }


@dataclass(frozen=True, slots=True)
class Against:
    """A run against the first: every difference is its number less the first's.

    Trials are paired where at least half of the smaller run's trials began like those of the same number in the first
    run. ``orientation_difference``: the median of |difference| [rad] over pairs of converged trials.
    """

    run: str
    pairs: int
    paired: bool
    only_first_converged: int
    only_other_converged: int
    converged: Estimate | None
    differences: Mapping[str, Estimate | None]
    ratios: Mapping[str, Estimate | None]
    orientation_difference: float | None


@dataclass(frozen=True, slots=True)
class Comparison:
    """Everything ``compare`` says; what could not be measured is None.

    ``measures``: what each of MEASURES is called that some run has. Medians are over all finished trials that have the
    measure, those of costs over converged ones. ``sameness`` of every pair of runs.
    """

    measures: Mapping[str, str]
    runs: tuple[ComparedRun, ...]
    against_first: tuple[Against, ...]
    sameness: tuple[Sameness, ...]


def comparison(runs: Sequence[tuple[Evidence, Summary]]) -> Comparison:
    """The comparison of runs with the first of them. Raises DiagnosticError when the spec of one cannot be read."""
    evidences = [evidence for evidence, _ in runs]
    known = {
        name: measure
        for name, measure in MEASURES.items()
        if any(len(measure.values(evidence.records)) for evidence in evidences)
    }
    equal = {(i, j): pairs_of(evidences[i], evidences[j]) for i, j in combinations(range(len(evidences)), 2)}
    return Comparison(
        {name: measure.label for name, measure in known.items()},
        tuple(_compared(evidence, summary, known) for evidence, summary in runs),
        tuple(
            held_against(evidences[0], other, equal[0, place], known) for place, other in enumerate(evidences[1:], 1)
        ),
        samenesses(evidences, equal),
    )


def _compared(evidence: Evidence, summary: Summary, known: Mapping[str, Measure]) -> ComparedRun:
    medians = {name: median(measure.values(evidence.records)) for name, measure in known.items()}
    return ComparedRun(summary, tuple(evidence.folder.manifest.settings), medians)


def held_against(first: Evidence, other: Evidence, pairs: Pairs, known: Mapping[str, Measure]) -> Against:
    """How a run differs from the first in these measures; ``pairs``: as of :func:`pairs_of`."""
    paired = len(pairs) > 0 and 2 * len(pairs) >= min(len(first.records), len(other.records))
    if paired:
        converged = difference_of_paired_shares(_converged([b for _, b in pairs]), _converged([a for a, _ in pairs]))
    else:
        converged = difference_of_shares(_converged(other.records), _converged(first.records))
    differences, ratios = {}, {}
    for name, measure in known.items():
        theirs, ours = (
            measure.paired(pairs) if paired else (measure.values(first.records), measure.values(other.records))
        )
        differences[name] = difference_of_medians(ours, theirs, paired=paired)
        if measure.ratio:
            ratios[name] = ratio_of_medians(ours, theirs, paired=paired)
    turned = [abs(a.orientation_end - b.orientation_end) for a, b in pairs if _has_converged(a) and _has_converged(b)]
    return Against(
        run=str(other.folder.path),
        pairs=len(pairs),
        paired=paired,
        only_first_converged=sum(_has_converged(a) and not _has_converged(b) for a, b in pairs),
        only_other_converged=sum(_has_converged(b) and not _has_converged(a) for a, b in pairs),
        converged=converged,
        differences=differences,
        ratios=ratios,
        orientation_difference=median(turned),
    )


def pairs_of(first: Evidence, other: Evidence) -> Pairs:
    """Trials of the same number that began alike, whatever became of them: first run's, other run's.

    In worlds with a hand, where all that was drawn is equal: the two may differ in engine, mount, sensing or
    controller. In the floating world contacts are drawn by the seed, over the object: both must be equal.
    """
    ground = _ground(first)
    if ground != _ground(other):
        return []
    unplaced = len(ground) > 0  # of trials that begin without a hand nothing is drawn but contacts
    known = {record.number: record for record in first.records if unplaced or record.start}
    return [
        (known[record.number], record)
        for record in other.records
        if record.number in known and known[record.number].start == record.start
    ]


def _ground(evidence: Evidence) -> tuple[object, ...]:
    """What must be the same for equal draws to be equal starts."""
    scene, seed = evidence.program.spec.scene, evidence.folder.manifest.seed
    handless = not evidence.program.world.has("hand")
    return (scene.world, seed, scene.hand, scene.object) if handless else ()


def _has_converged(record: TrialRecord) -> bool:
    return record.outcome is Outcome.CONVERGED


def _converged(records: Sequence[TrialRecord]) -> Flags:
    return np.array([_has_converged(record) for record in records], dtype=bool)


def comparison_tables(found: Comparison) -> list[Table]:
    """The tables of a comparison: a column for each run."""
    runs = found.runs
    names = [str(place) for place in range(1, len(runs) + 1)]
    tables = (
        sameness_table(found.sameness, names),
        _outcomes(runs, names),
        _modes(runs, names),
        _medians(found, names),
        _against_table(found, names[1:]),
    )
    return [made for made in tables if made.rows]


def methods_of(found: Comparison) -> list[str]:
    """How the intervals of differences came about, each way once, with the runs that it holds for."""
    ways: dict[str, list[str]] = {}
    for place, other in enumerate(found.against_first, 2):
        medians = next((estimate for estimate in other.differences.values() if estimate), None)
        for what, estimate in (("shares", other.converged), ("medians", medians)):
            if estimate is not None:
                ways.setdefault(f"{what}: {estimate.method}", []).append(str(place))
    found_ways = [f"Run {', '.join(places)} against run 1, {way}." for way, places in ways.items()]
    return ["Intervals hold 95 %; those of shares of one run are Wilson's.", *found_ways]


def _side_by_side(
    title: str, first: str, names: Sequence[str], rows: Sequence[tuple[Any, ...]], note: str = ""
) -> Table:
    """A table without the rows in which no run has anything."""
    told = tuple(row for row in rows if any(not _is_nothing(cell) for cell in row[1:]))
    return Table(title, (Column(first), *(Column(name, TEXT) for name in names)), told, note)


def _is_nothing(cell: object) -> bool:
    return (cell.value if isinstance(cell, Value) else cell) in (None, NOTHING)


_SHARE = replace(TEXT, text=lambda found: f"{percent(found.share)}, {percents(found.interval)}")
_COUNTED = replace(TEXT, text=lambda found: f"{found.count}: {_SHARE.text(found)}")
_STOPPED = replace(TEXT, text=lambda found: f"{len(found.trials)}: {_SHARE.text(found)}")
_MODE = replace(TEXT, text=lambda mode: f"{mode.centre:.2f} rad: {_SHARE.text(mode)}")


def _outcomes(runs: Sequence[ComparedRun], names: Sequence[str]) -> Table:
    tables = [{entry.outcome: entry for entry in run.summary.outcome_table} for run in runs]
    known = dict.fromkeys([Outcome.CONVERGED.value, *[name for found in tables for name in found]])
    finished = [f"{run.summary.finished} of {run.summary.asked}" for run in runs]
    rows: list[tuple[object, ...]] = [("finished trials", *finished)]
    rows += [(name, *[_outcome(found, name) for found in tables]) for name in known]
    return _side_by_side("How trials ended: shares with 95 % intervals", "outcome", names, rows)


def _outcome(found: Mapping[str, OutcomeCount], name: str) -> object:
    return Value(found[name], _COUNTED) if name in found else "0" if found else None


def _modes(runs: Sequence[ComparedRun], names: Sequence[str]) -> Table:
    columns, stops = [run.summary.modes for run in runs], [run.summary.stopped for run in runs]
    rows = [
        (str(place + 1), *[Value(modes[place] if place < len(modes) else None, _MODE) for modes in columns])
        for place in range(max(map(len, columns)))
    ]
    rows.append((STOPPED, *[Value(stopped if stopped.of else None, _STOPPED) for stopped in stops]))
    note = "of trials that settled in contact; stopped ones: of all that ended in contact"
    return _side_by_side("Modes of the end orientation: shares with 95 % intervals", "mode", names, rows, note)


def _medians(found: Comparison, names: Sequence[str]) -> Table:
    rows = [
        (label, *[Value(run.medians[name], fixed(MEASURES[name].digits)) for run in found.runs])
        for name, label in found.measures.items()
    ]
    return _side_by_side("Medians", "measure", names, rows, "* of converged trials")


def _against_table(found: Comparison, names: Sequence[str]) -> Table:
    others, measures = found.against_first, {name: MEASURES[name] for name in found.measures}
    points = replace(TEXT, text=_points)
    rows: list[tuple[object, ...]] = [
        ("pairs of equal starts", *[_pairs(other) for other in others]),
        ("share converged, difference", *[Value(other.converged, points) for other in others]),
        ("pairs of which only this one converged", *[other.only_other_converged for other in others]),
        ("pairs of which only run 1 converged", *[other.only_first_converged for other in others]),
    ]
    for name, measure in measures.items():
        if measure.ratio:
            rows.append((f"{measure.label}, ratio", *[_estimate(other.ratios[name], ".3g") for other in others]))
    for name, measure in measures.items():
        told = [_estimate(other.differences[name], f"+.{measure.digits}f") for other in others]
        rows.append((f"{measure.label}, difference", *told))
    turned = [Value(other.orientation_difference, fixed(3)) for other in others]
    rows.append(("turned from its pair, median [rad] *", *turned))
    note = "* of converged trials; where trials are paired, of pairs that both converged"
    return _side_by_side("Against run 1: differences and ratios with 95 % intervals", "", names, rows, note)


def _pairs(other: Against) -> str:
    return f"{other.pairs}" if other.paired or not other.pairs else f"{other.pairs}, too few to be used"


def _points(estimate: Estimate) -> str:
    assert estimate.interval is not None
    low, high = estimate.interval
    return f"{100 * estimate.value:+.0f} points, {100 * low:+.0f} to {100 * high:+.0f}"


def _estimate(estimate: Estimate | None, form: str) -> str:
    if estimate is None:
        return NOTHING
    if estimate.interval is None:
        return f"{estimate.value:{form}}, too few for an interval"
    low, high = ("∞" if not math.isfinite(end) else f"{end:{form}}" for end in estimate.interval)
    return f"{estimate.value:{form}}, {low} to {high}"
