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


@dataclass(frozen=True, slots=True)
class MeanCourses:
    """The mean force and moment residuals of some trials by tick, each trial keeping its last value.

    ``falls``: after how many ticks they fall, the mean over all that they fall by; None for one that does not fall.
    lag: by how many ticks the moment falls later, −∞ where one of them does not fall, with an interval of trials drawn
    again. rise: how far the mean force rises, between the two ticks at which the mean of one half of the trials rises
    most, that of the other half, so that what is only scatter does not count; with Student's interval. Intervals are
    None for fewer than FEWEST trials.
    """

    trials: int
    falls: tuple[float | None, float | None]
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
    rises, everyone = rises_of_others(force), np.ones((1, count))
    fell, then_fell = fall_times(force, everyone), fall_times(moment, everyone)
    lags, risen = None, None
    if count >= FEWEST:
        again = np.concatenate(list(drawn_again(count)))
        lags = percentile_interval(_later(fall_times(force, again), fall_times(moment, again)))
        risen = mean_interval(rises)
    falls = (_known(float(fell[0])), _known(float(then_fell[0])))
    return MeanCourses(count, falls, float(_later(fell, then_fell)[0]), lags, float(rises.mean()), risen)


def fall_times(courses: Array, drawn: Array) -> Array:
    """After how many ticks the means of courses (n, t) fall, for each way (r, n) of drawing these: (r,).

    The mean over all levels between start and end of the time that is spent above a level: ∫(ρ − ρ_end)/(ρ_0 − ρ_end)
    dt, which is τ of ρ = exp(−t/τ). NaN where a mean does not end lower than it starts.
    """
    above = drawn @ (courses - courses[:, -1:]).sum(axis=1)
    fallen = drawn @ (courses[:, 0] - courses[:, -1])
    return np.asarray(np.divide(above, fallen, out=np.full(len(drawn), np.nan), where=fallen > 0.0))


def rises_of_others(courses: Array) -> Array:
    """How far each of courses (n, t) rises where the mean of the other half rises most, (n,)."""
    rises, halves = np.zeros(len(courses)), (slice(0, None, 2), slice(1, None, 2))
    for half, other in (halves, halves[::-1]):
        if len(courses[other]):
            first, last = _steepest(courses[other].mean(axis=0))
            rises[half] = courses[half, last] - courses[half, first]
    return rises


def _later(first: Array, then: Array) -> Array:
    return np.nan_to_num(then - first, nan=-math.inf)


def _known(time: float) -> float | None:
    return time if math.isfinite(time) else None


def _steepest(course: Array) -> tuple[int, int]:
    """The ticks between which a course (t,) rises most, from the least that it was before."""
    last = int(np.argmax(course - np.minimum.accumulate(course)))
    return int(np.argmin(course[: last + 1])), last


def _is_whole(course: ResidualCourse) -> bool:
    return len(course.force) > 0 and bool(np.isfinite(course.force).all() and np.isfinite(course.moment).all())
