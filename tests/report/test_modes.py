"""The modes of angles: how many, where they part, how sure their shares are."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from graspdsl.arrays import Array
from graspdsl.report.modes import modes, of_one_mode, share_intervals
from graspdsl.report.statistics import LEAST_BANDWIDTH, RIGHT_ANGLE, wilson

angles = st.lists(st.floats(0.0, RIGHT_ANGLE), min_size=1, max_size=60).map(np.array)


@pytest.mark.slow
@settings(deadline=None, max_examples=40)
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
@pytest.mark.parametrize("count", [1, 3, 30])
def test_equal_values_are_one_mode(count: int) -> None:
    """Wherever they lie: half-way between two points of the grid the density has two equal heights and no one peak."""
    for value in np.linspace(0.0, RIGHT_ANGLE, 65):
        (mode,) = modes(np.full(count, value))
        assert mode.centre == pytest.approx(value, abs=LEAST_BANDWIDTH)  # a bound draws a peak nearby to it
        assert mode.members == tuple(range(count))


def two_modes(random: np.random.Generator, count: int) -> Array:
    """Four of five near π/2, one of five near 0.45 rad, where the chapter's first experiment has its peaks."""
    aside = random.random(count) < 0.2
    near = random.normal(RIGHT_ANGLE, 0.1, count)
    return np.where(aside, random.normal(0.45, 0.1, count), np.minimum(near, math.pi - near))


LIKELY = 3  # of 20 at 5 % each, which more than exceed in one of 60


@pytest.mark.slow
@pytest.mark.parametrize("count", [20, 58, 200])
def test_even_values_seldom_seem_to_have_two_modes(count: int) -> None:
    random = np.random.default_rng(1000 + count)
    assert sum(len(modes(random.uniform(0.0, RIGHT_ANGLE, count))) > 1 for _ in range(20)) <= LIKELY


@pytest.mark.slow
def test_two_modes_are_found_and_their_shares_are_in_the_intervals() -> None:
    random = np.random.default_rng(1)
    samples = [two_modes(random, 58) for _ in range(12)]
    found = [(values, ranks) for values in samples if len(ranks := modes(values)) == 2]
    assert len(found) >= 7  # at 80 % each, fewer are found in one of 50
    covered = 0
    for values, ranks in found:
        intervals = share_intervals(values, ranks)
        covered += all(low <= share <= high for share, (low, high) in zip((0.8, 0.2), intervals, strict=True))
        for (low, high), mode in zip(intervals, ranks, strict=True):
            given = wilson(len(mode.members), 58)
            assert low <= given[0] < given[1] <= high
    assert covered >= len(found) - 2  # at 95 % each, fewer are in one of 50


def test_three_clusters_are_three_modes_with_their_values() -> None:
    middles = np.repeat([0.2, 0.8, 1.4], [10, 20, 30])
    values = middles + np.random.default_rng(7).normal(0.0, 0.02, 60)
    found = modes(values)
    assert [len(mode.members) for mode in found] == [30, 20, 10]
    assert [mode.centre for mode in found] == pytest.approx([1.4, 0.8, 0.2], abs=0.02)
    assert [set(middles[list(mode.members)]) for mode in found] == [{1.4}, {0.8}, {0.2}]


@pytest.mark.slow
def test_modes_part_in_the_valley_and_leave_no_tail_to_a_neighbour() -> None:
    random = np.random.default_rng(200)
    for _ in range(10):
        values = random.choice([0.2, 0.8, 1.4], 200) + random.normal(0.0, 0.08, 200)
        assert len(modes(values.clip(0.0, RIGHT_ANGLE))) == 3


def test_values_at_both_ends_are_two_modes() -> None:
    large, small = modes(np.repeat([0.0, RIGHT_ANGLE], [12, 30]))
    assert (small.low, large.high) == (0.0, RIGHT_ANGLE)
    assert (large.centre, small.centre) == pytest.approx((RIGHT_ANGLE, 0.0), abs=0.01)
    assert share_intervals(np.repeat([0.0, RIGHT_ANGLE], [12, 30]), [large, small])[1] == pytest.approx(
        wilson(12, 42), abs=0.03
    )


@pytest.mark.parametrize("count", [1, 2, 3, 5])
def test_a_few_values_have_one_mode(count: int) -> None:
    (mode,) = modes(np.linspace(0.0, RIGHT_ANGLE, count))
    assert len(mode.members) == count
    assert share_intervals(np.linspace(0.0, RIGHT_ANGLE, count), [mode]) == [wilson(count, count)]


@pytest.mark.slow
def test_modes_do_not_depend_on_the_order_of_values_or_on_when_they_are_asked_for() -> None:
    random = np.random.default_rng(8)
    values = two_modes(random, 58)
    order = random.permutation(58)
    first, again, other = modes(values), modes(values), modes(values[order])
    assert first == again
    assert len(first) == 2
    assert share_intervals(values, first) == share_intervals(values[order], other)
    for mode, same in zip(first, other, strict=True):
        assert (same.centre, same.low, same.high) == (mode.centre, mode.low, mode.high)
        assert sorted(order[list(same.members)]) == list(mode.members)


def test_grasps_a_hundredth_apart_are_of_one_mode() -> None:
    random = np.random.default_rng(4)
    values = np.concatenate([random.normal(0.80, 1e-3, 30), random.normal(0.81, 1e-3, 30)])
    assert len(modes(values)) == 1
    assert len(modes(np.concatenate([values, values + 0.4]))) == 2


@settings(deadline=None)
@given(st.lists(st.floats(0.0, 8.0), min_size=1, max_size=20).map(np.array))
def test_the_law_with_one_mode_rises_and_falls_and_is_as_much(heights: Array) -> None:
    made = of_one_mode(heights)
    peak = int(np.argmax(heights))
    assert np.all(np.diff(made[:peak]) >= -1e-12)
    assert np.all(np.diff(made[peak + 1 :]) <= 1e-12)
    assert made.max() == pytest.approx(made[peak])
    assert made.sum() == pytest.approx(heights.sum())
