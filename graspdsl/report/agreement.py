"""Whether two runs of equal starts say the same: outcomes, modes, and what their converged trials ended with.

Trials are paired by number. Each quantity has a tolerance, and a verdict by where the 95 % interval of what was
measured lies: within the tolerance they agree, outside they differ, else it cannot be told.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from graspdsl.arrays import Array
from graspdsl.report.comparison import pairs_of
from graspdsl.report.evidence import Evidence
from graspdsl.report.judgements import Judgement, Verdict, judged_share, judged_value
from graspdsl.report.sameness import Pairs
from graspdsl.report.statistics import (
    FEWEST,
    RIGHT_ANGLE,
    Estimate,
    Interval,
    difference_of_paired_shares,
    median,
    median_interval,
    share_interval,
)
from graspdsl.report.summary import ModeSummary, Summary
from graspdsl.report.tables import Format, fixed
from graspdsl.report.wording import counted, number, percent, percents
from graspdsl.trials.outcomes import Outcome
from graspdsl.trials.record import TrialRecord

SAME_OUTCOME = 0.85  # of pairs, at least
PEAKS_APART = 0.1  # rad, at most, of a mode in two runs


@dataclass(frozen=True, slots=True)
class Quantity:
    """What a trial ended with: ``of`` takes it from a record, (m,) numbers in its unit. Two trials differ by the number
    that differs most. ``tolerance``: up to where they agree; ``written``: how it is shown."""

    label: str
    tolerance: float
    written: Format
    of: Callable[[TrialRecord], Sequence[float]]

    @property
    def bound(self) -> str:
        """The tolerance, in the unit that it is shown in."""
        return f"{self.written.sorts_by(self.tolerance):g} {self.written.unit}".rstrip()

    def differences(self, pairs: Pairs) -> Array:
        """How far the second trial of each pair (n,) is from the first, without those where there is no number."""
        apart = [np.subtract(self.of(other), self.of(one)) for one, other in pairs]
        most = [gaps[np.argmax(np.abs(gaps))] for gaps in apart if gaps.size and np.isfinite(gaps).all()]
        return np.array(most, dtype=float)


# A fifth of what specs usually end at: ‖ρ_f‖ < 0.1 and ‖ρ_m‖ < 5 mm, at forces of 0.5 N.
QUANTITIES: Mapping[str, Quantity] = {
    "orientation_end": Quantity("orientation", 0.03, fixed(4, "rad"), lambda r: (r.orientation_end,)),
    "force_residual_end": Quantity("‖ρ_f‖", 0.02, fixed(4), lambda r: (r.force_residual_end,)),
    "moment_residual_end": Quantity("‖ρ_m‖", 0.001, fixed(2, "mm", 1e3), lambda r: (r.moment_residual_end,)),
    "contact_force": Quantity("contact force", 0.1, fixed(3, "N"), lambda r: r.contact_forces),
}


@dataclass(frozen=True, slots=True)
class Agreement:
    """Of pairs that both converged, how far a quantity of the second trial is from the first's, in its unit.

    ``typical``: the median of the sizes of the differences, which is judged, with its interval, None of too few.
    ``shift``: the median of the differences. ``largest`` in size.
    """

    typical: float | None
    interval: Interval | None
    shift: float | None
    shift_interval: Interval | None
    largest: float | None
    tolerance: float
    judgement: Judgement


@dataclass(frozen=True, slots=True)
class SameOutcome:
    """Of so many ``pairs`` how many ended alike, the share with its exact interval, None of none.

    ``apart``: outcomes of the others, first run's, second run's, with how many. ``converged``: of how many both trials
    did, the first alone, the second alone and neither; ``shift``: the difference of the two shares that converged.
    ``least``: the share from which on runs agree.
    """

    pairs: int
    same: int
    share: float | None
    interval: Interval | None
    apart: tuple[tuple[str, str, int], ...]
    converged: tuple[int, int, int, int]
    shift: Estimate | None
    judgement: Judgement
    least: float = SAME_OUTCOME


@dataclass(frozen=True, slots=True)
class ModeInBoth:
    """The range of a mode in two runs, first run's, second run's: the median of those in it [rad], None of none, and
    their share with its interval."""

    centres: tuple[float | None, float | None]
    shares: tuple[float, float]
    intervals: tuple[Interval, Interval]


@dataclass(frozen=True, slots=True)
class SameModes:
    """The modes of the run that has more of them, in both; ``tolerance`` [rad]: up to where their peaks agree."""

    modes: tuple[ModeInBoth, ...]
    judgement: Judgement
    tolerance: float = PEAKS_APART


@dataclass(frozen=True, slots=True)
class Against:
    """What a run, by its place, has in common with another that is its measure."""

    run: int
    measure: int
    outcome: SameOutcome
    modes: SameModes
    quantities: Mapping[str, Agreement]

    @property
    def judgements(self) -> list[Judgement]:
        """All of them."""
        return [self.outcome.judgement, self.modes.judgement, *(found.judgement for found in self.quantities.values())]


Known = tuple[Evidence, Summary]


def against(runs: Sequence[Known], run: int, measure: int) -> Against:
    """What a run has in common with the one that is its measure."""
    pairs = pairs_of(runs[measure][0], runs[run][0])
    modes = same_modes(runs[measure], runs[run])
    return Against(run, measure, same_outcome(pairs), modes, {name: agreement_in(name, pairs) for name in QUANTITIES})


def agreement_in(name: str, pairs: Pairs) -> Agreement:
    """How far those of the pairs that both converged agree in one of QUANTITIES."""
    both = [pair for pair in pairs if all(record.outcome is Outcome.CONVERGED for record in pair)]
    quantity = QUANTITIES[name]
    found = quantity.differences(both)
    sizes = np.abs(found)
    typical, interval = median(sizes), median_interval(sizes)
    return Agreement(
        *(typical, interval, median(found), median_interval(found), float(sizes.max()) if len(sizes) else None),
        quantity.tolerance,
        judged_value(typical, interval, len(sizes), 0.0, quantity.tolerance),
    )


def same_outcome(pairs: Pairs) -> SameOutcome:
    """How many of the pairs ended alike."""
    ends = Counter((one.outcome.value, other.outcome.value) for one, other in pairs)
    same = sum(count for (one, other), count in ends.items() if one == other)
    good = np.array([[record.outcome is Outcome.CONVERGED for record in pair] for pair in pairs], dtype=bool)
    first, other = good.reshape(-1, 2).T
    table = (first & other, first & ~other, other & ~first, ~first & ~other)
    both, only_first, only_other, neither = (int(np.count_nonzero(kind)) for kind in table)
    return SameOutcome(
        len(pairs),
        same,
        same / len(pairs) if pairs else None,
        share_interval(same, len(pairs)) if pairs else None,
        tuple((one, two, count) for (one, two), count in ends.most_common() if one != two),
        (both, only_first, only_other, neither),
        difference_of_paired_shares(other, first),
        judged_share(same, len(pairs), SAME_OUTCOME),
    )


def same_modes(first: Known, other: Known) -> SameModes:
    """Whether two runs have the same modes.

    They differ where a share is outside of its interval in the other run, or a mode is elsewhere. Where one run has a
    mode more and shares are within, it cannot be told.
    """
    ends = [_settled(evidence) for evidence, _ in (first, other)]
    few = min(map(len, ends))
    modes = [summary.modes for _, summary in (first, other)]
    more = int(len(modes[1]) > len(modes[0]))
    ranges = sorted(modes[more], key=lambda mode: mode.centre)
    if few < FEWEST or not ranges:
        return SameModes((), Judgement(Verdict.UNTOLD, few, FEWEST))
    found, alike = list[ModeInBoth](), True
    for mode in ranges:
        before, after = (_inside(values, mode) for values in ends)
        shares = len(before) / len(ends[0]), len(after) / len(ends[1])
        intervals = share_interval(len(before), len(ends[0])), share_interval(len(after), len(ends[1]))
        intervals = (intervals[0], mode.interval) if more else (mode.interval, intervals[1])
        found.append(ModeInBoth((median(before), median(after)), shares, intervals))
        far = len(before) > 0 and len(after) > 0 and abs(np.median(after) - np.median(before)) > PEAKS_APART
        alike = alike and not far and all(low <= shares[1 - run] <= high for run, (low, high) in enumerate(intervals))
    verdict = Verdict.DIFFERS if not alike else Verdict.AGREES if len(modes[0]) == len(modes[1]) else Verdict.UNTOLD
    return SameModes(tuple(found), Judgement(verdict, few))


def _settled(evidence: Evidence) -> Array:
    """Where the trials ended [rad] that modes are of."""
    settled = [record for record in evidence.records if record.outcome.settled and evidence.touching(record)]
    ends: Array = np.array([record.orientation_end for record in settled], dtype=float)
    return np.asarray(ends[np.isfinite(ends)])


def _inside(values: Array, mode: ModeSummary) -> Array:
    low, high = mode.range
    return np.asarray(values[(values >= low) & ((values < high) | (high >= RIGHT_ANGLE))])


Row = tuple[str, str, str, Judgement]  # what it is about, when it agrees, what was measured, and what that says


def rows_of(found: Against) -> list[Row]:
    """What two runs have in common, a line each: outcomes, modes, then each of QUANTITIES."""
    outcome, modes = found.outcome, found.modes
    rows: list[Row] = [
        ("same outcome", f"≥ {percent(outcome.least)} of pairs", _said_outcome(outcome), outcome.judgement),
        ("modes", f"peaks ± {modes.tolerance:g} rad, shares alike", _said_modes(modes), modes.judgement),
    ]
    for name, quantity in QUANTITIES.items():
        one = found.quantities[name]
        rows.append((f"{quantity.label}, off by", f"≤ {quantity.bound}", _said(one, quantity.written), one.judgement))
    return rows


def _said_outcome(found: SameOutcome) -> str:
    if found.interval is None:
        return "no trials that began alike"
    return f"{found.same} of {found.pairs}: {percent(found.share)} ({percents(found.interval)})"


def _said_modes(found: SameModes) -> str:
    if not found.modes:
        return f"of {counted(found.judgement.trials, 'trial', 'trials')}"
    first, other = (
        ", ".join(f"{number(mode.centres[run], 'rad', 2)}: {percent(mode.shares[run])}" for mode in found.modes)
        for run in (0, 1)
    )
    return f"{first}; against {other}"


def _said(found: Agreement, written: Format) -> str:
    if found.typical is None:
        return "no pair converged"
    typical, largest = (written.written(value, with_unit=True) for value in (found.typical, found.largest))
    ends = f" ({' to '.join(map(written.text, found.interval))})" if found.interval else ""
    return f"{typical}{ends}, largest {largest}"
