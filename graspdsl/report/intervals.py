"""Intervals of 95 % without a model of the values: of a share, a median, a density's peak, and from resamples."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np
from scipy import stats

from graspdsl.arrays import Array
from graspdsl.report.statistics import RIGHT_ANGLE, bandwidth, density

RESAMPLES, AT_ONCE = 2000, 50  # so that those of very many trials do not fill the memory
BOOTSTRAP_SEED = 0  # an interval is the same whenever it is made
FEWEST = 6  # the range of n values covers their median with 1 − 2^(1−n): 95 % only from six on

Interval = tuple[float, float]


def share_interval(part: float, whole: float) -> Interval:
    """The interval of a share after Clopper and Pearson 1934: each end is passed with a chance of at most 2.5 %."""
    low = float(stats.beta.ppf(0.025, part, whole - part + 1.0)) if part > 0.0 else 0.0
    high = float(stats.beta.ppf(0.975, part + 1.0, whole - part)) if part < whole else 1.0
    return low, high


def median_interval(values: Array) -> Interval | None:
    """The interval between two order statistics that covers the median of what values (n,) are drawn from.

    Exact, by the binomial law: each end is passed with a chance of at most 2.5 %. None for fewer than FEWEST values.
    """
    count = len(values)
    if count < FEWEST:
        return None
    ordered = np.sort(values)
    passed, chance, rank = 0.0, -count * math.log(2.0), 0  # chance: log of that of just ``rank`` values below it
    while passed + math.exp(chance) <= 0.025:
        passed += math.exp(chance)
        chance += math.log((count - rank) / (rank + 1))
        rank += 1
    return float(ordered[rank - 1]), float(ordered[count - rank])


def peak_interval(values: Array, low: float, high: float) -> Interval | None:
    """The bootstrap interval of where between two angles the density of angles (n,) in 0…π/2 peaks [rad].

    All angles are drawn again, at the bandwidth that they have. None for fewer than FEWEST between the two.
    """
    if np.count_nonzero((values >= low) & (values <= high)) < FEWEST:
        return None
    grid = np.linspace(0.0, RIGHT_ANGLE, 513)
    grid = grid[(grid >= low) & (grid <= high)]
    width = bandwidth(values)
    kernels = np.column_stack([density(np.array([value]), grid, width) for value in values])
    peaks = [grid[np.argmax(kernels @ drawn.T, axis=0)] for drawn in drawn_again(len(values))]
    return percentile_interval(np.concatenate(peaks))


def drawn_again(count: int) -> Iterator[Array]:
    """How often each of so many trials is drawn in each of RESAMPLES resamples: (AT_ONCE, count) at a time."""
    random = np.random.default_rng(BOOTSTRAP_SEED)
    for _ in range(RESAMPLES // AT_ONCE):
        yield random.multinomial(count, np.full(count, 1.0 / count), size=AT_ONCE).astype(float)


def percentile_interval(resampled: Array) -> Interval:
    """The middle 95 % of resampled numbers (r,), each end one of them: it may be infinite."""
    ordered = np.sort(resampled)
    last = len(ordered) - 1
    return float(ordered[math.floor(0.025 * last)]), float(ordered[math.ceil(0.975 * last)])
