"""Differences between two runs with intervals: shares by Newcombe's score methods, medians by the bootstrap.

Every difference is the other's number less the first's, with a 95 % interval.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from graspdsl.arrays import Array, Flags
from graspdsl.report.intervals import BOOTSTRAP_SEED, FEWEST, RESAMPLES, percentile_interval
from graspdsl.report.statistics import wilson

PAIRED_SHARES = "paired score interval (Newcombe 1998, Stat. Med. 17:2635, method 10)"
UNPAIRED_SHARES = "hybrid score interval (Newcombe 1998, Stat. Med. 17:873, method 10)"
PAIRED_MEDIANS = f"percentile bootstrap over pairs, {RESAMPLES} resamples"
UNPAIRED_MEDIANS = f"percentile bootstrap over each run's trials, {RESAMPLES} resamples"


@dataclass(frozen=True, slots=True)
class Estimate:
    """A number with its 95 % interval, which may end at infinity; no interval where there are too few values for one.

    ``method``: in words.
    """

    value: float
    interval: tuple[float, float] | None
    method: str
    count: int


def difference_of_shares(other: Flags, first: Flags) -> Estimate | None:
    """The difference of two independent shares: Newcombe's hybrid score interval. None where nothing was counted.

    other: (m,), first: (n,).
    """
    if len(other) == 0 or len(first) == 0:
        return None
    above, below = float(np.mean(other)), float(np.mean(first))
    above_low, above_high = wilson(int(np.sum(other)), len(other))
    below_low, below_high = wilson(int(np.sum(first)), len(first))
    value = above - below
    low = value - math.hypot(above - above_low, below_high - below)
    high = value + math.hypot(above_high - above, below - below_low)
    return Estimate(value, (max(-1.0, low), min(1.0, high)), UNPAIRED_SHARES, min(len(other), len(first)))


def difference_of_paired_shares(other: Flags, first: Flags) -> Estimate | None:
    """The difference of two shares over the same n subjects: Newcombe's paired score interval. None for no pairs.

    other, first: (n,), a pair a place. The interval narrows with the correlation of the two, which is corrected for
    continuity.
    """
    count = len(other)
    if count == 0:
        return None
    above, below = float(np.mean(other)), float(np.mean(first))
    above_low, above_high = wilson(int(np.sum(other)), count)
    below_low, below_high = wilson(int(np.sum(first)), count)
    correlation = _correlation(other, first)
    value = above - below
    low = value - _side(above - above_low, below_high - below, correlation)
    high = value + _side(above_high - above, below - below_low, correlation)
    return Estimate(value, (max(-1.0, low), min(1.0, high)), PAIRED_SHARES, count)


def _side(own: float, others: float, correlation: float) -> float:
    return math.sqrt(max(0.0, own * own - 2.0 * correlation * own * others + others * others))


def _correlation(other: Flags, first: Flags) -> float:
    """The phi coefficient of a table of pairs, a positive one drawn towards zero by half a pair."""
    both, neither = int(np.sum(other & first)), int(np.sum(~other & ~first))
    only_other, only_first = int(np.sum(other & ~first)), int(np.sum(~other & first))
    margins = (both + only_other) * (neither + only_first) * (both + only_first) * (neither + only_other)
    if margins == 0:
        return 0.0
    product = float(both * neither - only_other * only_first)
    if product > 0:
        product = max(0.0, product - len(other) / 2)
    return product / math.sqrt(margins)


def difference_of_medians(other: Array, first: Array, *, paired: bool) -> Estimate | None:
    """The difference of two medians. None where there are no values.

    other: (m,), first: (n,); ``paired``: m = n, and trials are drawn again in pairs. The interval errs on the wide side
    for pairs: in simulations of 12 and of 40 pairs it held the true difference 98 and 99 times of 100.
    """
    if len(other) == 0 or len(first) == 0:
        return None
    value = float(np.median(other) - np.median(first))
    ours, theirs = _medians_drawn_again(other, first, paired=paired)
    return _estimate(value, ours - theirs, ours - theirs, min(len(other), len(first)), paired=paired)


def ratio_of_medians(other: Array, first: Array, *, paired: bool) -> Estimate | None:
    """The ratio of two medians of numbers not below zero, as :func:`difference_of_medians`.

    None also where the first median is zero. A resample whose first median is zero has an infinite ratio; where both
    are zero it may be anything, which widens the interval at either end.
    """
    if len(other) == 0 or len(first) == 0 or np.median(first) == 0.0:
        return None
    value = float(np.median(other) / np.median(first))
    ours, theirs = _medians_drawn_again(other, first, paired=paired)
    with np.errstate(divide="ignore", invalid="ignore"):
        ratios = ours / theirs
    least, most = np.nan_to_num(ratios, nan=0.0, posinf=np.inf), np.nan_to_num(ratios, nan=np.inf, posinf=np.inf)
    return _estimate(value, least, most, min(len(other), len(first)), paired=paired)


def _medians_drawn_again(other: Array, first: Array, *, paired: bool) -> tuple[Array, Array]:
    """The medians (RESAMPLES,) of both, their values drawn again."""
    random = np.random.default_rng(BOOTSTRAP_SEED)
    rows = random.integers(len(other), size=(RESAMPLES, len(other)))
    columns = rows if paired else random.integers(len(first), size=(RESAMPLES, len(first)))
    return np.median(other[rows], axis=1), np.median(first[columns], axis=1)


def _estimate(value: float, least: Array, most: Array, count: int, *, paired: bool) -> Estimate:
    """The estimate whose interval ends where resampled numbers do: at the low end ``least``, at the high ``most``."""
    method = PAIRED_MEDIANS if paired else UNPAIRED_MEDIANS
    if count < FEWEST:
        return Estimate(value, None, method, count)
    return Estimate(value, (percentile_interval(least)[0], percentile_interval(most)[1]), method, count)
