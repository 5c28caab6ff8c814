"""Statistics against independent references."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import stats

from graspdsl.report.statistics import LEAST_BANDWIDTH, RIGHT_ANGLE, bandwidth, density, wilson

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
