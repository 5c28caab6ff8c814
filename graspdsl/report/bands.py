"""Many courses as one: the mean by tick and the band that most trials keep to."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from graspdsl.arrays import Array

LOW, HIGH = 10.0, 90.0  # percentiles
MOST_TICKS = 400  # that a curve is drawn through


@dataclass(frozen=True, slots=True)
class Band:
    """Curves over the same ticks, (t,) each: the mean and two percentiles over trials, in the unit of the values.

    A trial that has ended keeps its last value, so that all trials count at every tick; ``running`` is how many had
    not ended.
    """

    ticks: Array
    mean: Array
    low: Array
    high: Array
    running: Array


def held_to_the_longest(courses: Sequence[Array]) -> Array:
    """Courses (n_i,), one at least and none empty, as rows (n, t) of the longest one's length; each keeps its last
    value."""
    ticks = np.arange(max(map(len, courses)))
    return np.stack([course[np.minimum(ticks, len(course) - 1)] for course in courses])


def band(courses: Sequence[Array]) -> Band | None:
    """The mean and the 10th and 90th percentiles of courses (n_i,) of any lengths; None where there is none.

    Long ones are looked at on MOST_TICKS ticks, evenly spaced.
    """
    known = [course for course in courses if len(course) and np.isfinite(course).all()]
    if not known:
        return None
    lengths = np.array([len(course) for course in known])
    longest = int(lengths.max())
    ticks = np.unique(np.round(np.linspace(0, longest - 1, min(longest, MOST_TICKS))).astype(int))
    values = np.stack([course[np.minimum(ticks, len(course) - 1)] for course in known])
    low, high = np.percentile(values, [LOW, HIGH], axis=0)
    running = (lengths[:, None] > ticks).sum(axis=0)
    return Band(ticks.astype(float), values.mean(axis=0), low, high, running.astype(float))
