"""The excess mass of a second mode against its definition, and against laws of which it is known."""

from __future__ import annotations

from itertools import combinations

import numpy as np
import pytest
from scipy import stats

from graspdsl.arrays import Array, Rows
from graspdsl.report.excess_mass import CELLS, cells_of, counted_in, edges, excess_mass, levels_of, smoothed
from graspdsl.report.statistics import LEAST_BANDWIDTH, RIGHT_ANGLE, density

WIDTH = RIGHT_ANGLE / CELLS


def by_all_intervals(counts: Rows) -> float:
    """The excess mass of one histogram, by looking at every pair of intervals that there is."""
    mass = smoothed(counts, LEAST_BANDWIDTH) / counts.sum()
    most = 0.0
    for level in levels_of(mass[None])[0]:
        sums = np.concatenate([[0.0], np.cumsum(mass - level)])
        first = [max(0.0, *(sums[b] - sums[a] for a, b in combinations(range(cut + 1), 2))) for cut in range(1, CELLS)]
        second = [
            max(0.0, *(sums[b] - sums[a] for a, b in combinations(range(cut, CELLS + 1), 2))) for cut in range(1, CELLS)
        ]
        one = max(sums[b] - sums[a] for a, b in combinations(range(CELLS + 1), 2))
        most = max(most, max(a + b for a, b in zip(first, second, strict=True)) - one)
    return most


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(2))
def test_it_is_what_two_intervals_have_more_than_one(seed: int) -> None:
    random = np.random.default_rng(seed)
    counts = random.multinomial(40, random.dirichlet(np.full(CELLS, 0.3)))
    assert excess_mass(counts[None])[0][0] == pytest.approx(by_all_intervals(counts), abs=1e-8)


@pytest.mark.parametrize("share", [0.1, 0.3, 0.5])
def test_of_two_far_clusters_it_is_nearly_the_lesser(share: float) -> None:
    """Two normal peaks of the kernel's spread, their middles 0.8 rad apart: at a level λ either the lesser is given up,
    or the gap is bridged. Few levels are looked at, so that it may be somewhat less."""
    values = np.repeat([0.4, 1.2], [round(1000 * share), round(1000 * (1.0 - share))])
    levels = np.linspace(0.01, 3.9 * share, 400)
    half = LEAST_BANDWIDTH * np.sqrt(-2.0 * np.log(levels / (share * stats.norm.pdf(0.0) / LEAST_BANDWIDTH)))
    others = LEAST_BANDWIDTH * np.sqrt(-2.0 * np.log(levels / ((1 - share) * stats.norm.pdf(0.0) / LEAST_BANDWIDTH)))
    lesser = share * (1.0 - 2.0 * stats.norm.sf(half / LEAST_BANDWIDTH)) - 2.0 * half * levels
    between = share * stats.norm.sf(half / LEAST_BANDWIDTH) + (1 - share) * stats.norm.sf(others / LEAST_BANDWIDTH)
    exact = np.minimum(lesser, levels * (0.8 - half - others) - between).max()
    (excess,), (begins,) = excess_mass(counted_in(values)[None])
    assert 0.8 * exact <= excess <= exact + 1e-3
    assert edges()[begins] == pytest.approx(0.8, abs=2 * WIDTH)


@pytest.mark.parametrize("values", [np.full(9, 0.3), np.zeros(4), np.full(3, RIGHT_ANGLE), np.zeros(0)])
def test_equal_values_have_none(values: Array) -> None:
    (excess,), _ = excess_mass(counted_in(values)[None])
    assert excess == 0.0


def test_a_mirror_changes_nothing() -> None:
    counts = np.random.default_rng(4).multinomial(30, np.full(CELLS, 1.0 / CELLS), size=20)
    (excess, begins), (mirrored, ends) = excess_mass(counts), excess_mass(counts[:, ::-1])
    np.testing.assert_allclose(mirrored, excess)
    assert np.all(np.abs(CELLS - ends - begins) <= 1)


def test_smoothing_is_the_kernel_density() -> None:
    values = np.random.default_rng(5).uniform(0.0, RIGHT_ANGLE, 30)
    middles = edges()[cells_of(values)] + WIDTH / 2
    found = smoothed(counted_in(values), LEAST_BANDWIDTH) / (30 * WIDTH)
    assert found == pytest.approx(density(middles, edges()[:-1] + WIDTH / 2, LEAST_BANDWIDTH), abs=1e-4)
