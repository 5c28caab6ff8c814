"""How claims say what was measured: numbers with their 95 % intervals."""

from __future__ import annotations

import math

import numpy as np

from graspdsl.arrays import Array
from graspdsl.report.intervals import FEWEST, Interval, median_interval, share_interval
from graspdsl.report.judgements import Judgement, Verdict
from graspdsl.report.mean_courses import SETTLED, MeanCourses
from graspdsl.report.wording import NOTHING, counted, number, percent, percents

ENDED = "that ended in contact"
MARKS = {Verdict.AGREES: "✓ agrees", Verdict.DIFFERS: "✗ differs", Verdict.UNTOLD: "? cannot be told"}


def with_interval(value: float | None, interval: Interval | None, unit: str, digits: int) -> str:
    """A number and where its interval ends, if it has one."""
    if value is None or interval is None:
        return number(value, unit, digits)
    low, high = (_rounded(end, digits) for end in interval)
    return f"{_rounded(value, digits)} {unit}".rstrip() + f" ({low} to {high})"


def _rounded(value: float, digits: int) -> str:
    return f"{round(value, digits) + 0.0:.{digits}f}".replace("inf", "∞").replace("-", "−")  # zero has no sign


def median_of(values: Array, unit: str, digits: int) -> str:
    """The median of values (n,) and its interval."""
    return with_interval(float(np.median(values)) if len(values) else None, median_interval(values), unit, digits)


def share_of(part: int, whole: int, of: str = ENDED) -> str:
    """A share in percent, its interval, and of how many grasps."""
    if not whole:
        return NOTHING
    return f"{percent(part / whole)} ({percents(share_interval(part, whole))}) of {whole} {of}"


def settling(found: MeanCourses) -> str:
    """When the mean residuals have fallen, and how much later the moment's."""
    if not found.trials:
        return NOTHING
    force, moment = ("never" if tick is None else f"after {counted(tick, 'tick', 'ticks')}" for tick in found.settled)
    said = f"{percent(SETTLED)} down: the mean force {force}, the mean moment {moment}"
    if not math.isfinite(found.lag):
        return said
    return f"{said}, {with_interval(found.lag, found.lag_interval, '', 0)} later"


def rising(found: MeanCourses) -> str:
    """How far the mean force residual rises."""
    if not found.trials:
        return NOTHING
    ends = None if found.rise_interval is None else (100 * found.rise_interval[0], 100 * found.rise_interval[1])
    return f"largest rise {with_interval(100 * found.rise, ends, '%', 0)}"


def why_untold(judgement: Judgement, whole: int) -> str:
    """How many trials a verdict would be of and how many it takes, and in a run of how many; of ``whole`` so far."""
    there = f"{counted(judgement.trials, 'such trial', 'such trials')} cannot tell"
    if judgement.needed is None:
        return f"{there}, nor would more like them"
    about = "at least" if judgement.trials < FEWEST else "about"
    if judgement.trials in (0, whole):
        return f"{there}: {about} {judgement.needed} can"
    run = math.ceil(judgement.needed * whole / judgement.trials)
    return f"{there}: {about} {judgement.needed} can, in a run of {run}"
