"""Which runs are the same, point by point: trajectories of equal trials, held against one another for every pair."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import combinations
from typing import Literal

import numpy as np

from graspdsl.arrays import Array
from graspdsl.compiler.alike import SAME_PROGRAM, same_by_law
from graspdsl.diagnostics import listed
from graspdsl.report.evidence import Evidence
from graspdsl.report.statistics import median
from graspdsl.report.tables import TEXT, Column, Table, Value
from graspdsl.report.wording import counted, percent
from graspdsl.trials.record import TrialRecord
from graspdsl.trials.trajectories import CHANNELS, TICK, Rows

Pairs = Sequence[tuple[TrialRecord, TrialRecord]]  # of one run, of another
Verdict = Literal["identical", "same to rounding", "different", "no trajectories", "no equal trials"]

# What happened in the world, whatever controllers made of it: ends as records have them in full, ticks as stored.
ENDS = {"orientation_end": "rad", "force_residual_end": "1", "moment_residual_end": "m"}
HAPPENED = ("points", "normals", "forces", "joints", "object_position", "object_rotation")


@dataclass(frozen=True, slots=True)
class Sameness:
    """What two runs, by their numbers from 1, have in common.

    Of so many equal ``trials`` some are ``identical`` at every tick, to the last bit of what is stored, some are the
    same ``to_rounding``, and all others part: at ``parts_at``, the median of the first ticks at which they do.
    ``lost``: equal trials of which a trajectory cannot be read, which are not among these. ``largest``: the largest
    differences by unit, over all ticks that both have. ``by_law``: why the two must be the
    same but for rounding, where that is known.
    """

    runs: tuple[int, int]
    verdict: Verdict
    trials: int
    identical: int
    to_rounding: int
    parts_at: float | None
    lost: int
    largest: Mapping[str, float]
    by_law: str | None

    @property
    def is_same(self) -> bool:
        """Whether no trial parts."""
        return self.verdict in ("identical", "same to rounding")


@dataclass(slots=True)
class _Tally:
    identical: int = 0
    to_rounding: int = 0
    parted: list[int] = field(default_factory=list)
    lost: int = 0
    largest: dict[str, float] = field(default_factory=dict)

    def add(self, one: TrialRecord, other: TrialRecord, mine: Rows, theirs: Rows) -> None:
        """One more pair of equal trials."""
        parts, largest = parting(mine, theirs)
        if parts is not None or one.outcome is not other.outcome:
            self.parted.append(_ticks(mine) if parts is None else parts)
        else:
            for name, unit in ENDS.items():
                gap = abs(getattr(one, name) - getattr(other, name))
                largest[unit] = max(largest.get(unit, 0.0), 0.0 if math.isnan(gap) else gap)
            differs = any(largest.values())
            self.to_rounding += differs
            self.identical += not differs
        for unit, gap in largest.items():
            self.largest[unit] = max(gap, self.largest.get(unit, 0.0))


def samenesses(evidences: Sequence[Evidence], equal_trials: Mapping[tuple[int, int], Pairs]) -> tuple[Sameness, ...]:
    """What every pair of runs has in common. ``equal_trials``: the records of these, by the places of two runs."""
    tallies = {pair: _Tally() for pair in combinations(range(len(evidences)), 2)}
    of_number: dict[int, list[tuple[tuple[int, int], TrialRecord, TrialRecord]]] = {}
    for pair, trials in equal_trials.items():
        for one, other in trials:
            of_number.setdefault(one.number, []).append((pair, one, other))
    for number, found in of_number.items():
        rows = {place: evidences[place].trajectory(number) for place in {place for pair, *_ in found for place in pair}}
        for pair, one, other in found:
            mine, theirs = (rows[place] for place in pair)
            if mine is None or theirs is None:
                tallies[pair].lost += 1
            else:
                tallies[pair].add(one, other, mine, theirs)
    return tuple(_sameness(pair, tally, evidences) for pair, tally in tallies.items())


def parting(mine: Rows, theirs: Rows) -> tuple[int | None, dict[str, float]]:
    """The first tick at which two trajectories part, of those that both have kept, None where they never do, and their
    largest differences by unit, those that are zero too.

    They part where a number differs by more than neighbouring floats of 32 bits, in which trajectories are stored, do
    at the largest of its channel: what differs by less was the same but for rounding. One that goes on where the other
    has ended parts from it there.
    """
    both, of_mine, of_theirs = np.intersect1d(_kept(mine), _kept(theirs), assume_unique=True, return_indices=True)
    ended, latest = sorted((_ticks(mine), _ticks(theirs)))
    first, largest = None if ended == latest else ended, dict[str, float]()
    for name in HAPPENED if len(both) else ():
        one, other = (
            np.asarray(rows[name][kept], dtype=np.float64).reshape(len(both), -1)
            for rows, kept in ((mine, of_mine), (theirs, of_theirs))
        )
        if one.shape != other.shape:
            return 0, largest
        if not one.size:
            continue
        gaps = np.where(np.isnan(one) & np.isnan(other), 0.0, np.abs(one - other))
        unit = CHANNELS[name].unit
        known = np.where(np.isnan(gaps), 0.0, gaps)
        largest[unit] = max(largest.get(unit, 0.0), float(known.max()))
        parted = both[(gaps > _rounding(one, other)).any(axis=1) | np.isnan(gaps).any(axis=1)]
        if len(parted):
            first = int(parted[0]) if first is None else min(first, int(parted[0]))
    return first, largest


def _kept(rows: Rows) -> Array:
    """The numbers of the ticks that are kept."""
    return np.asarray(rows[TICK], dtype=np.float64) if rows else np.zeros(0)


def _ticks(rows: Rows) -> int:
    return int(rows[TICK][-1]) + 1 if rows else 0


def _rounding(one: Array, other: Array) -> float:
    size = np.nanmax(np.abs(np.concatenate([one, other, np.zeros((1, one.shape[1]))])))
    return float(np.spacing(np.float32(size)))


def _sameness(pair: tuple[int, int], tally: _Tally, evidences: Sequence[Evidence]) -> Sameness:
    trials = tally.identical + tally.to_rounding + len(tally.parted)
    verdict: Verdict = "identical"
    if not trials:
        verdict = "no trajectories" if tally.lost else "no equal trials"
    elif tally.parted:
        verdict = "different"
    elif tally.to_rounding:
        verdict = "same to rounding"
    one, other = (evidences[place].program for place in pair)
    return Sameness(
        runs=(pair[0] + 1, pair[1] + 1),
        verdict=verdict,
        trials=trials,
        identical=tally.identical,
        to_rounding=tally.to_rounding,
        parts_at=median(tally.parted),
        lost=tally.lost,
        largest=tally.largest,
        by_law=same_by_law(one, other) if trials else None,
    )


def sameness_table(found: Sequence[Sameness], names: Sequence[str]) -> Table:
    """A row and a column for each run, for every pair what it has in common."""
    cells = {pair.runs: pair for pair in found}
    places = range(1, len(names) + 1)
    rows = tuple(
        (names[row - 1], *(Value(cells[row, other], _CELL) if row < other else "" for other in places[1:]))
        for row in places[:-1]
    )
    columns = (Column("run"), *(Column(name, TEXT) for name in names[1:]))
    note = (
        "identical: to the last bit of what is stored. same: but for rounding. Else the share of equal trials that "
        "part, and the median of the first ticks at which they do."
    )
    if any(pair.verdict == "no trajectories" for pair in found):
        note += " lost: there are equal trials, but not their trajectories."
    return Table("Same or different, point by point", columns, rows, note)


def said_of(found: Sequence[Sameness]) -> list[str]:
    """Which runs are the same, in sentences, with why where that is known; and which are not though they should be."""
    same = {pair.runs: pair for pair in found if pair.is_same}
    count, groups = max((pair.runs[1] for pair in found), default=0), list[list[int]]()
    for run in range(1, count + 1):
        group = next((known for known in groups if all((other, run) in same for other in known)), None)
        if group is None:
            groups.append([run])
        else:
            group.append(run)
    said = [_of_group([same[pair] for pair in combinations(group, 2)], group) for group in groups if len(group) > 1]
    for pair in found:
        if pair.verdict == "different" and pair.by_law:
            one, other = pair.runs
            parted = pair.trials - pair.identical - pair.to_rounding
            but = f"Runs {one} and {other} part in {parted} of {counted(pair.trials, 'equal trial', 'equal trials')}"
            if pair.by_law == SAME_PROGRAM:
                said.append(f"{but}, though {pair.by_law}.")
            else:
                said.append(f"{but}, where rounding has grown; but for rounding they are the same: {pair.by_law}.")
    return said


def _of_group(pairs: Sequence[Sameness], runs: Sequence[int]) -> str:
    named = f"Runs {listed([str(run) for run in runs])}"
    trials = counted(min(pair.trials for pair in pairs), "equal trial", "equal trials")
    if all(pair.verdict == "identical" for pair in pairs):
        said = f"{named} are the same, point by point, to the last bit, in {trials}."
    else:
        largest: dict[str, float] = {}
        for pair in pairs:
            largest |= {unit: max(gap, largest.get(unit, 0.0)) for unit, gap in pair.largest.items()}
        gaps = listed([f"{gap:.2g} {f'({unit})' if unit == '1' else unit}" for unit, gap in largest.items() if gap])
        within = f" They differ by {gaps} at most."
        said = f"{named} are the same, point by point, but for rounding, in {trials}.{within}"
    reasons = dict.fromkeys(pair.by_law for pair in pairs if pair.by_law)
    return f"{said} They must be: {'; '.join(reasons)}." if all(pair.by_law for pair in pairs) else said


def _cell(pair: Sameness) -> str:
    if pair.verdict == "different":
        return f"{percent(1.0 - (pair.identical + pair.to_rounding) / pair.trials)}, tick {pair.parts_at:.0f}"
    return {"same to rounding": "same", "no trajectories": "lost", "no equal trials": "none equal"}.get(
        pair.verdict, pair.verdict
    )


_CELL = replace(TEXT, text=_cell)
