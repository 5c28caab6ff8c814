"""What the mean courses of residuals do, with 95 % intervals: which falls first, and whether one rises again."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from graspdsl.arrays import Array
from graspdsl.report.bands import held_to_the_longest
from graspdsl.report.evidence import Course
from graspdsl.report.intervals import FEWEST, Interval, drawn_again, percentile_interval

SETTLED = 0.9  # of the way that a mean residual falls


@dataclass(frozen=True, slots=True)
class MeanCourses:
    """The mean force and moment residuals of some trials by tick, each trial keeping its last value.

    ``settled``: the first ticks at which they are SETTLED down, None for one that does not fall. lag: by how many ticks
    the moment is later, −∞ where one of them does not fall. rise: the largest rise of the force above what it was, over
    where it starts. Intervals are of trials drawn again, None for fewer than FEWEST.
    """

    trials: int
    settled: tuple[int | None, int | None]
    lag: float
    lag_interval: Interval | None
    rise: float
    rise_interval: Interval | None


def mean_courses(courses: Sequence[Course]) -> MeanCourses | None:
    """What the means of courses do, of those that are whole; None where there is none."""
    whole = [course for course in courses if _is_whole(course)]
    if not whole:
        return None
    force, moment = (held_to_the_longest([getattr(course, kind) for course in whole]) for kind in ("force", "moment"))
    count = len(whole)
    means = force.mean(axis=0), moment.mean(axis=0)
    lags, rises = None, None
    if count >= FEWEST:
        again = [(row @ force, row @ moment) for row in drawn_again(count) / count]
        lags = percentile_interval(np.array([lag_of(*pair) for pair in again]))
        rises = percentile_interval(np.array([rise_of(first) for first, _ in again]))
    settled = settled_at(means[0]), settled_at(means[1])
    return MeanCourses(count, settled, lag_of(*means), lags, rise_of(means[0]), rises)


def settled_at(course: Array) -> int | None:
    """The first tick at which a course (t,) has fallen most of the way from its start to its end; None: it does not."""
    if not course[-1] < course[0]:
        return None
    bound = course[-1] + (1.0 - SETTLED) * (course[0] - course[-1])
    return int(np.argmax(course <= bound))


def lag_of(force: Array, moment: Array) -> float:
    """By how many ticks a moment (t,) settles after a force (t,); −∞ where one of them does not fall."""
    first, then = settled_at(force), settled_at(moment)
    return -math.inf if first is None or then is None else float(then - first)


def rise_of(course: Array) -> float:
    """The largest rise of a course (t,) above the least that it was before, over where it starts."""
    rise = float((course - np.minimum.accumulate(course)).max())
    return 0.0 if rise == 0.0 else rise / float(course[0]) if course[0] > 0.0 else math.inf


def _is_whole(course: Course) -> bool:
    return len(course.force) > 0 and bool(np.isfinite(course.force).all() and np.isfinite(course.moment).all())
