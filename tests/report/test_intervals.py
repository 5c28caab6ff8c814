"""Intervals against the binomial law and against their coverage."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import stats

from graspdsl.report.statistics import (
    FEWEST,
    RESAMPLES,
    drawn_again,
    median_interval,
    peak_interval,
    percentile_interval,
    share_interval,
    wilson,
)


@pytest.mark.parametrize("count", [*range(1, 80), 1000, 5000])
def test_the_median_s_interval_is_the_narrowest_that_covers(count: int) -> None:
    """Of values 0…n−1 its ends are ranks; the chance to pass one is at most 2.5 %, and one rank further in above."""
    found = median_interval(np.random.default_rng(count).permutation(count).astype(float))
    if found is None:
        assert count < FEWEST
        assert stats.binom.cdf(0, count, 0.5) > 0.025
        return
    low, high = found
    assert low + high == count - 1
    assert stats.binom.cdf(low, count, 0.5) <= 0.025 < stats.binom.cdf(low + 1, count, 0.5)


@pytest.mark.slow
@pytest.mark.parametrize("count", [1, 2, 5, 28, 58, 400])
def test_a_share_s_interval_is_exact(count: int) -> None:
    for part in range(count + 1):
        score = stats.binomtest(part, count).proportion_ci(0.95, method="wilson")
        assert wilson(part, count) == pytest.approx((score.low, score.high), abs=1e-12)
        found = stats.binomtest(part, count).proportion_ci(0.95, method="exact")
        assert share_interval(part, count) == pytest.approx((found.low, found.high), abs=1e-9)


@pytest.mark.slow
def test_a_peak_s_interval_holds_the_peak() -> None:
    """Of two clusters, the place of the smaller one, as often as it should; it is hardly wider than peaks scatter."""
    random, held, times, widths, centres = np.random.default_rng(11), 0, 200, [], []
    for _ in range(times):
        values = np.concatenate([random.normal(0.5, 0.1, 30), random.normal(1.3, 0.08, 50)])
        found = peak_interval(np.clip(values, 0.0, np.pi / 2), 0.0, 0.9)
        assert found is not None
        held += found[0] <= 0.5 <= found[1]
        widths.append(found[1] - found[0])
        centres.append(sum(found) / 2)
    assert stats.binomtest(held, times, 0.95, alternative="less").pvalue > 1e-3
    assert np.mean(widths) < 1.6 * 2 * 1.96 * np.std(centres)


def test_a_peak_of_equal_angles_is_there() -> None:
    assert peak_interval(np.full(9, np.pi / 2), 0.0, np.pi / 2) == (np.pi / 2, np.pi / 2)
    values = np.concatenate([np.full(5, 0.3), np.full(30, 1.5)])
    assert peak_interval(values, 0.0, 0.8) is None
    assert peak_interval(values, 0.8, np.pi / 2) is not None


def test_each_resample_draws_as_many_as_there_are() -> None:
    drawn = np.concatenate(list(drawn_again(7)))
    assert drawn.shape == (RESAMPLES, 7)
    assert (drawn.sum(axis=1) == 7).all()
    scatter = np.sqrt(7 * (1 / 7) * (6 / 7) / RESAMPLES)  # of the mean count of each
    assert np.abs(drawn.mean(axis=0) - 1.0).max() < 5 * scatter


def test_percentiles_are_numbers_that_were_drawn_infinite_or_not() -> None:
    assert percentile_interval(np.arange(1001.0)[::-1]) == (25.0, 975.0)
    assert percentile_interval(np.r_[np.full(30, -np.inf), np.zeros(940), np.full(30, np.inf)]) == (-np.inf, np.inf)
    assert percentile_interval(np.r_[np.full(20, -np.inf), np.zeros(980)]) == (0.0, 0.0)
