"""Statistics of runs: medians, densities, courses as one, and intervals of 95 %.

Intervals of a share are Wilson's where it is told, and exact where a claim is judged by it; those of medians are of
order statistics; of differences of shares Newcombe's score methods, of medians the bootstrap. What draws at random
does so from BOOTSTRAP_SEED: an interval is the same whenever it is made. scipy.stats takes its time to load and is left
to differences of medians; the rest needs no more than scipy.special.
"""

from __future__ import annotations

import math
import warnings
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from graspdsl.arrays import Array, Flags

RIGHT_ANGLE = math.pi / 2
ORIENTATIONS = np.linspace(0.0, RIGHT_ANGLE, 257)  # rad, that a density is drawn through
LEAST_BANDWIDTH = 0.05  # rad; what the chapter's figures still resolve
LOW, HIGH = 10.0, 90.0  # percentiles
MOST_TICKS = 400  # that a curve is drawn through
RESAMPLES, AT_ONCE = 2000, 50  # so that those of very many trials do not fill the memory
BOOTSTRAP_SEED = 0
FEWEST = 6  # the range of n values covers their median with 1 − 2^(1−n): 95 % only from six on

Interval = tuple[float, float]

PAIRED_SHARES = "paired score interval (Newcombe 1998, Stat. Med. 17:2635, method 10)"
UNPAIRED_SHARES = "hybrid score interval (Newcombe 1998, Stat. Med. 17:873, method 10)"
PAIRED_MEDIANS = f"percentile bootstrap over pairs, {RESAMPLES} resamples"
RANKS = f"percentile bootstrap over pairs of Spearman's rank correlation, {RESAMPLES} resamples"
UNPAIRED_MEDIANS = f"percentile bootstrap over each run's trials, {RESAMPLES} resamples"


def wilson(successes: int, count: int) -> Interval:
    """The Wilson score interval of a share; (0, 1) when nothing was counted."""
    if count == 0:
        return 0.0, 1.0
    from scipy.special import ndtri

    share, squared = successes / count, float(ndtri(0.975)) ** 2 / count
    middle = share + squared / 2.0
    half = math.sqrt(squared * (share * (1.0 - share) + squared / 4.0))
    low, high = ((middle + side) / (1.0 + squared) for side in (-half, half))
    return low if successes > 0 else 0.0, high if successes < count else 1.0


def share_interval(part: float, whole: float) -> Interval:
    """The interval of a share after Clopper and Pearson 1934: each end is passed with a chance of at most 2.5 %."""
    from scipy.special import betaincinv

    low = float(betaincinv(part, whole - part + 1.0, 0.025)) if part > 0.0 else 0.0
    high = float(betaincinv(part + 1.0, whole - part, 0.975)) if part < whole else 1.0
    return low, high


def median_interval(values: Array) -> Interval | None:
    """The interval between two order statistics that covers the median of what values (n,) are drawn from.

    Exact, by the binomial law: each end is passed with a chance of at most 2.5 %. None for fewer than FEWEST values.
    """
    if len(values) < FEWEST:
        return None
    from scipy.special import bdtr

    ordered, ranks = np.sort(values), np.arange(len(values) // 2)
    passed = int(np.flatnonzero(bdtr(ranks, len(values), 0.5) <= 0.025)[-1])
    return float(ordered[passed]), float(ordered[-1 - passed])


def mean_interval(values: Array) -> Interval:
    """Student's interval of the mean of what values (n,) are drawn from."""
    from scipy.special import stdtrit

    error = float(values.std(ddof=1)) / math.sqrt(len(values))
    mean, half = float(values.mean()), float(stdtrit(len(values) - 1, 0.975)) * error
    return mean - half, mean + half


def median(values: Iterable[float]) -> float | None:
    """The median of those values that are finite; None where there are none."""
    known = [value for value in values if math.isfinite(value)]
    return float(np.median(known)) if known else None


def bandwidth(values: Array) -> float:
    """Silverman's rule for a Gaussian kernel, on the smaller of the two usual spreads, at least LEAST_BANDWIDTH."""
    if len(values) < 2:
        return LEAST_BANDWIDTH
    upper, lower = np.percentile(values, [75, 25])
    spread = min(float(np.std(values, ddof=1)), float(upper - lower) / 1.34) or float(np.std(values, ddof=1))
    return max(LEAST_BANDWIDTH, 0.9 * spread / float(len(values) ** 0.2))


def density(values: Array, at: Array, width: float) -> Array:
    """A Gaussian kernel density on 0…π/2, reflected at both ends so that it integrates to one.

    What is reflected past the other end is reflected once more: for a width up to π/6 less than 1e-8 is lost.
    """
    mirrored = np.concatenate([sign * values + turn for sign in (1, -1) for turn in (-math.pi, 0.0, math.pi)])
    kernels = np.exp(-0.5 * ((at[:, None] - mirrored) / width) ** 2)
    return np.asarray(kernels.sum(axis=1) / (len(values) * width * math.sqrt(2 * math.pi)))


def peak_interval(values: Array, low: float, high: float) -> Interval | None:
    """The bootstrap interval of where the density of those angles (n,) in 0…π/2 peaks that are between two [rad].

    They are drawn again at the bandwidth that they have. None for fewer than FEWEST.
    """
    values = values[(values >= low) & (values <= high)]
    if len(values) < FEWEST:
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


@dataclass(frozen=True, slots=True)
class Estimate:
    """A number with its 95 % interval, which may end at infinity; no interval where there are too few values for one.

    ``method``: in words.
    """

    value: float
    interval: Interval | None
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
    return _estimate(np.subtract, other, first, paired=paired)


def ratio_of_medians(other: Array, first: Array, *, paired: bool) -> Estimate | None:
    """The ratio of two medians of numbers not below zero, as :func:`difference_of_medians`.

    None also where the first median is zero. A resample whose first median is zero has an infinite ratio; where both
    are zero it may be anything, which widens the interval at either end.
    """
    if len(other) == 0 or len(first) == 0 or np.median(first) == 0.0:
        return None
    with np.errstate(divide="ignore", invalid="ignore"):
        return _estimate(np.divide, other, first, paired=paired)


def rank_correlation(one: Array, other: Array) -> Estimate | None:
    """Spearman's rank correlation of n pairs of numbers (n,), with the bootstrap's interval. None for fewer than FEWEST
    pairs, or where one of the two is the same in all.

    A resample in which one is the same in all may have any correlation, which widens the interval at either end.
    """
    if len(one) < FEWEST or np.ptp(one) == 0.0 or np.ptp(other) == 0.0:
        return None
    from scipy.stats import rankdata

    drawn = np.random.default_rng(BOOTSTRAP_SEED).integers(len(one), size=(RESAMPLES, len(one)))
    rows = np.concatenate([np.arange(len(one))[None], drawn])
    with np.errstate(invalid="ignore"):
        deviations = [rankdata(values[rows], axis=1) - (len(one) + 1) / 2 for values in (one, other)]
        sizes = np.sqrt(np.prod([np.sum(part**2, axis=1) for part in deviations], axis=0))
        found = np.sum(deviations[0] * deviations[1], axis=1) / sizes
    low, _ = percentile_interval(np.nan_to_num(found[1:], nan=-1.0))
    _, high = percentile_interval(np.nan_to_num(found[1:], nan=1.0))
    return Estimate(float(found[0]), (low, high), RANKS, len(one))


def _estimate(of: Callable[[Array, Array], Array], other: Array, first: Array, *, paired: bool) -> Estimate:
    """A number of two medians with the bootstrap's interval.

    A resample in which it may be anything, which a difference never may, counts as 0 at the low end, as ∞ at the high.
    """
    value, count = float(of(np.asarray(np.median(other)), np.asarray(np.median(first)))), min(len(other), len(first))
    method = PAIRED_MEDIANS if paired else UNPAIRED_MEDIANS
    if count < FEWEST:
        return Estimate(value, None, method, count)
    from scipy import stats

    with warnings.catch_warnings():
        warnings.simplefilter("ignore", stats.DegenerateDataWarning)  # of its own interval, which is not used
        drawn = stats.bootstrap(
            (other, first),
            lambda ours, theirs, axis: of(np.median(ours, axis=axis), np.median(theirs, axis=axis)),
            n_resamples=RESAMPLES,
            paired=paired,
            vectorized=True,
            method="percentile",
            rng=np.random.default_rng(BOOTSTRAP_SEED),
        ).bootstrap_distribution
    low = percentile_interval(np.nan_to_num(drawn, nan=0.0, posinf=np.inf, neginf=-np.inf))[0]
    high = percentile_interval(np.nan_to_num(drawn, nan=np.inf, posinf=np.inf, neginf=-np.inf))[1]
    return Estimate(value, (low, high), method, count)
