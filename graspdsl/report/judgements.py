"""Whether a number of a run keeps a bound: it does, it does not, too few trials ended to tell, or it had to."""

from __future__ import annotations

import math
from bisect import bisect_left
from dataclasses import dataclass
from enum import StrEnum

from graspdsl.report.statistics import FEWEST, Interval, share_interval

MOST = 100_000  # trials that anyone may be asked for


class Verdict(StrEnum):
    """What a run says of a claim."""

    AGREES = "agrees"
    DIFFERS = "differs"
    UNTOLD = "cannot be told"
    NO_EVIDENCE = "no evidence"  # where no run could have shown anything else

    @property
    def mark(self) -> str:
        """The verdict with a sign before it."""
        return f"{_SIGNS[self]} {self.value}"


_SIGNS = {Verdict.AGREES: "✓", Verdict.DIFFERS: "✗", Verdict.UNTOLD: "?", Verdict.NO_EVIDENCE: "○"}


@dataclass(frozen=True, slots=True)
class Judgement:
    """A verdict with the trials that it is from.

    needed: about how many would tell, were they like these; None where it is told, or where none of up to MOST would.
    """

    verdict: Verdict
    trials: int
    needed: int | None = None


def judged_share(successes: int, count: int, low: float, high: float = 1.0) -> Judgement:
    """Whether a share lies between two bounds: by where its exact 95 % interval lies.

    Of no trials at all, ``needed`` is how many could agree at best.
    """
    verdict = _placed(share_interval(successes, count), low, high) if count else Verdict.UNTOLD
    if verdict is not Verdict.UNTOLD:
        return Judgement(verdict, count)
    share = successes / count if count else (1.0 if high == 1.0 else low)

    def told(trials: int) -> bool:
        return _placed(share_interval(share * trials, trials), low, high) is not Verdict.UNTOLD

    return Judgement(verdict, count, bisect_left(range(MOST + 1), True, lo=count + 1, key=told) if told(MOST) else None)


def judged_value(value: float | None, interval: Interval | None, trials: int, low: float, high: float) -> Judgement:
    """Whether a number lies between two bounds, by where its 95 % interval lies; None: of too few trials for one.

    ``needed`` supposes that the interval narrows with the root of the number of trials.
    """
    if value is None or interval is None:
        return Judgement(Verdict.UNTOLD, trials, FEWEST)
    verdict = _placed(interval, low, high)
    if verdict is not Verdict.UNTOLD:
        return Judgement(verdict, trials)
    if low <= value <= high:
        sides = [(value - interval[0], value - low), (interval[1] - value, high - value)]
    else:
        sides = [(value - interval[0], value - high)] if value > high else [(interval[1] - value, low - value)]
    if not all(math.isfinite(width) and gap > 0.0 for width, gap in sides):
        return Judgement(verdict, trials)
    needed = trials * max(width / gap for width, gap in sides) ** 2
    return Judgement(verdict, trials, max(trials + 1, math.ceil(needed)) if needed <= MOST else None)


def every(*judgements: Judgement) -> Judgement:
    """That all hold: one that differs decides, else the one that takes the largest run to be told."""
    for judgement in judgements:
        if judgement.verdict is Verdict.DIFFERS:
            return judgement
    untold = [judgement for judgement in judgements if judgement.verdict is Verdict.UNTOLD]
    return max(untold or judgements, key=lambda judgement: (judgement.needed or MOST) / max(judgement.trials, 1))


def _placed(interval: Interval, low: float, high: float) -> Verdict:
    if low <= interval[0] and interval[1] <= high:
        return Verdict.AGREES
    return Verdict.DIFFERS if interval[1] < low or interval[0] > high else Verdict.UNTOLD
