"""Statistics against independent references."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import stats

from graspdsl.report.statistics import LEAST_BANDWIDTH, RIGHT_ANGLE, bandwidth, density, modes, wilson

angles = st.lists(st.floats(0.0, RIGHT_ANGLE), min_size=1, max_size=60).map(np.array)


@given(st.integers(1, 500).flatmap(lambda count: st.tuples(st.integers(0, count), st.just(count))))
def test_wilson(case: tuple[int, int]) -> None:
    successes, count = case
    reference = stats.binomtest(successes, count).proportion_ci(0.95, method="wilson")
    assert wilson(successes, count) == pytest.approx((reference.low, reference.high), abs=1e-12)


def test_wilson_of_nothing_is_any_share() -> None:
    assert wilson(0, 0) == (0.0, 1.0)


def test_bandwidth_is_silverman_s_rule() -> None:
    values = np.random.default_rng(1).uniform(0.2, 1.4, 60)
    spread = min(np.std(values, ddof=1), stats.iqr(values) / 1.34)
    assert bandwidth(values) == pytest.approx(0.9 * spread * 60**-0.2)


@pytest.mark.parametrize("values", [[0.3], [0.3, 0.3, 0.3], [1.0, 1.001]])
def test_bandwidth_has_a_least_value(values: list[float]) -> None:
    assert bandwidth(np.array(values)) == LEAST_BANDWIDTH


def test_bandwidth_of_values_that_are_equal_but_for_a_few() -> None:
    values = np.array([0.1] * 9 + [1.5])
    assert bandwidth(values) == pytest.approx(0.9 * np.std(values, ddof=1) * 10**-0.2)


@given(angles)
def test_density_integrates_to_one(values: np.ndarray) -> None:
    grid = np.linspace(0.0, RIGHT_ANGLE, 4001)
    assert np.trapezoid(density(values, grid, bandwidth(values)), grid) == pytest.approx(1.0, abs=1e-6)


@pytest.mark.slow
@given(angles, st.floats(0.05, 0.4))
def test_density_is_the_sum_of_reflected_kernels(values: np.ndarray, width: float) -> None:
    at = np.linspace(0.0, RIGHT_ANGLE, 7)
    some = values[:10]
    images = [(v, -v, math.pi - v, v + math.pi, v - math.pi) for v in some]
    expected = [sum(stats.norm.pdf(a, c, width) for centres in images for c in centres) / len(some) for a in at]
    assert density(some, at, width) == pytest.approx(expected)


@given(angles)
def test_every_value_is_in_one_mode(values: np.ndarray) -> None:
    found = modes(values)
    assert sorted(member for mode in found for member in mode.members) == list(range(len(values)))
    assert [len(mode.members) for mode in found] == sorted((len(mode.members) for mode in found), reverse=True)
    for mode in found:
        assert 0.0 <= mode.low <= mode.centre <= mode.high <= RIGHT_ANGLE
        for member in mode.members:
            assert mode.low <= values[member] <= mode.high


def test_no_values_have_no_modes() -> None:
    assert modes(np.zeros(0)) == []


def test_two_clusters_are_two_modes() -> None:
    random = np.random.default_rng(2)
    values = np.concatenate([random.normal(0.4, 0.05, 20), random.normal(1.3, 0.05, 40)])
    order = random.permutation(60)
    large, small = modes(values[order])
    assert set(large.members) == set(np.flatnonzero(order >= 20))
    assert set(small.members) == set(np.flatnonzero(order < 20))
    assert large.centre == pytest.approx(1.3, abs=0.05)
    assert small.centre == pytest.approx(0.4, abs=0.05)
    assert 0.6 < large.low == small.high < 1.1
    assert (small.low, large.high) == (0.0, RIGHT_ANGLE)


@pytest.mark.parametrize("bound", [0.0, RIGHT_ANGLE])
def test_a_cluster_at_a_bound_is_one_mode_there(bound: float) -> None:
    values = np.abs(bound - np.abs(np.random.default_rng(3).normal(0.0, 0.02, 50)))
    (mode,) = modes(values)
    assert mode.centre == pytest.approx(bound, abs=0.02)
    assert len(mode.members) == 50


@pytest.mark.slow
@pytest.mark.parametrize("count", [1, 2, 3, 30])
def test_equal_values_are_one_mode(count: int) -> None:
    """Wherever they lie: half-way between two points of the grid the density has two equal heights and no one peak."""
    for value in np.linspace(0.0, RIGHT_ANGLE, 2049):
        (mode,) = modes(np.full(count, value))
        assert mode.centre == pytest.approx(value, abs=LEAST_BANDWIDTH)  # a bound draws a peak nearby to it
        assert mode.members == tuple(range(count))


def test_uniform_values_rarely_fall_apart() -> None:
    counts = [len(modes(np.random.default_rng(seed).uniform(0.0, RIGHT_ANGLE, 60))) for seed in range(200)]
    assert sum(count > 3 for count in counts) <= 10
