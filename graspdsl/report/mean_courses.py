"""What the mean courses of residuals do, with 95 % intervals: which falls first, and whether one rises again."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from graspdsl.arrays import Array
from graspdsl.report.evidence import ResidualCourse
from graspdsl.report.statistics import (
    FEWEST,
    Interval,
    drawn_again,
    held_to_the_longest,
    mean_interval,
    percentile_interval,
)

SETTLED = 0.9  # of the way that a mean residual falls


@dataclass(frozen=True, slots=True)
class MeanCourses:
    """The mean force and moment residuals of some trials by tick, each trial keeping its last value.

    ``settled``: the first ticks at which they are SETTLED down, None for one that does not fall. lag: by how many ticks
    the moment is later, −∞ where one of them does not fall, with an interval of trials drawn again. rise: how far the
    mean force rises, over where it starts: between the two ticks at which the mean of one half of the trials rises
    most, that of the other half, so that what is only scatter does not count; with Student's interval. Intervals are
    None for fewer than FEWEST trials.
    """

    trials: int
    settled: tuple[int | None, int | None]
    lag: float
    lag_interval: Interval | None
    rise: float
    rise_interval: Interval | None


def mean_courses(courses: Sequence[ResidualCourse]) -> MeanCourses | None:
    """What the means of courses do, of those that are whole; None where there is none."""
    whole = [course for course in courses if _is_whole(course)]
    if not whole:
        return None
    force, moment = (held_to_the_longest([getattr(course, kind) for course in whole]) for kind in ("force", "moment"))
    count = len(whole)
    means = force.mean(axis=0), moment.mean(axis=0)
    rises = rises_of_others(force)
    lags, risen = None, None
    if count >= FEWEST:
        again = ((drawn @ force, drawn @ moment) for drawn in drawn_again(count))
        lags = percentile_interval(np.array([lag_of(*pair) for pairs in again for pair in zip(*pairs, strict=True)]))
        risen = mean_interval(rises)
    settled = settled_at(means[0]), settled_at(means[1])
    return MeanCourses(count, settled, lag_of(*means), lags, float(rises.mean()), risen)


def settled_at(course: Array) -> int | None:
    """The first tick from which on a course (t,) has fallen most of the way from its start to its end; None: never."""
    if not course[-1] < course[0]:
        return None
    bound = course[-1] + (1.0 - SETTLED) * (course[0] - course[-1])
    return int(np.flatnonzero(course > bound)[-1]) + 1


def lag_of(force: Array, moment: Array) -> float:
    """By how many ticks a moment (t,) settles after a force (t,); −∞ where one of them does not fall."""
    first, then = settled_at(force), settled_at(moment)
    return -math.inf if first is None or then is None else float(then - first)


def rises_of_others(courses: Array) -> Array:
    """How far each of courses (n, t) rises where the mean of the other half rises most, (n,), over their mean start."""
    rises, halves = np.zeros(len(courses)), (slice(0, None, 2), slice(1, None, 2))
    for half, other in (halves, halves[::-1]):
        if len(courses[other]):
            first, last = _steepest(courses[other].mean(axis=0))
            rises[half] = courses[half, last] - courses[half, first]
    start = float(courses[:, 0].mean())
    return rises / start if start > 0.0 else np.where(rises > 0.0, math.inf, 0.0)


def _steepest(course: Array) -> tuple[int, int]:
    """The ticks between which a course (t,) rises most, from the least that it was before."""
    last = int(np.argmax(course - np.minimum.accumulate(course)))
    return int(np.argmin(course[: last + 1])), last


def _is_whole(course: ResidualCourse) -> bool:
    return len(course.force) > 0 and bool(np.isfinite(course.force).all() and np.isfinite(course.moment).all())
