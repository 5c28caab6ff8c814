"""By how much two intervals hold more of a sample of angles than one does: the excess mass of a second mode.

After D. W. Müller and G. Sawitzki, "Excess mass estimates and tests for multimodality", J. Am. Stat. Assoc. 86:738,
1991, by whom it is twice the dip of J. A. and P. M. Hartigan, Annals of Statistics 13:70, 1985. Here it is measured on
the density by a kernel of LEAST_BANDWIDTH: grasps that a figure does not tell apart are no two modes.
"""

from __future__ import annotations

import math

import numpy as np

from graspdsl.arrays import Array, Rows
from graspdsl.report.statistics import LEAST_BANDWIDTH, RIGHT_ANGLE

CELLS = 64  # of the right angle: two in a standard deviation of the kernel
EVERY, SHARES = 8, np.geomspace(0.02, 0.8, 8)  # levels are as high as every eighth cell, and as shares of the highest
ROUNDING = 1e-9


def counted_in(values: Array, cells: int = CELLS) -> Rows:
    """How many of angles (n,) in 0…π/2 are in each cell (cells,)."""
    return np.bincount(cells_of(values, cells), minlength=cells)


def cells_of(values: Array, cells: int = CELLS) -> Rows:
    """The cells that angles (n,) in 0…π/2 are in; one between two is in the upper."""
    return np.searchsorted(edges(cells)[1:-1], values, side="right")


def edges(cells: int = CELLS) -> Array:
    """Where cells begin, and where the last ends [rad]: (cells + 1,)."""
    return np.linspace(0.0, RIGHT_ANGLE, cells + 1)


def smoothed(counts: Rows, width: float) -> Array:
    """Histograms (…, m) of the right angle, smoothed by a Gaussian kernel [rad] that is reflected at both ends."""
    from scipy.fft import dct, idct

    waves = np.arange(counts.shape[-1]) * math.pi / RIGHT_ANGLE  # between walls heat spreads in cosines
    return np.asarray(idct(dct(counts.astype(float)) * np.exp(-0.5 * (waves * width) ** 2)))


def excess_mass(counts: Rows) -> tuple[Array, Rows]:
    """The excess mass (s,) of a second mode in histograms (s, CELLS), 0 to 0.5, and the cells (s,) where it begins.

    At a level λ an interval has its mass less λ times its length in excess. By how much two intervals have more of it
    than one is counted at the level where that is most; modes part at the lowest point between the two.
    """
    heights = smoothed(counts, LEAST_BANDWIDTH) / np.maximum(counts.sum(axis=-1, keepdims=True), 1)
    levels = levels_of(heights)
    gained = _gained(heights, levels)
    best, rows = gained.argmax(axis=-1), np.arange(len(counts))
    most = np.where(gained[rows, best] > ROUNDING, gained[rows, best], 0.0)
    return most, np.where(most > 0.0, _valley(heights, levels[rows, best]), 0)


def levels_of(heights: Array) -> Array:
    """The levels (s, l) at which the excess over densities (s, CELLS) is measured.

    Some are near to one another where a density is flat; the others, by equal factors apart, are for far peaks.
    """
    even = np.sort(heights, axis=-1)[:, EVERY // 2 :: EVERY]
    return np.hstack([even, heights.max(axis=-1, keepdims=True) * SHARES])


def _gained(heights: Array, levels: Array) -> Array:
    """By how much two intervals of densities (s, n) have more above levels (s, l) than one has: (s, l)."""
    ending = one = second = two = np.zeros_like(levels.T)  # the most up to a cell, and of what ends with it
    for height in heights.T:
        above = height - levels.T
        second = np.maximum(second, one) + above
        two = np.maximum(two, second)
        ending = np.maximum(ending, 0.0) + above
        one = np.maximum(one, ending)
    return (two - one).T


def _valley(heights: Array, levels: Array) -> Rows:
    """The cells (s,) that begin where densities (s, n) are least between the two intervals with the most above levels
    (s,); half-way between where they are as low."""
    above = heights - levels[:, None]
    left, right = _most_within(above), _most_within(above[:, ::-1])[:, ::-1]
    both = left[:, :-1] + right[:, 1:]
    between = both >= both.max(axis=-1, keepdims=True) - ROUNDING
    floors = np.where(between, heights[:, :-1] + heights[:, 1:], np.inf)
    least = floors <= floors.min(axis=-1, keepdims=True) + ROUNDING
    first, last = least.argmax(axis=-1), least.shape[-1] - 1 - least[:, ::-1].argmax(axis=-1)
    return np.asarray((first + last) // 2 + 1)


def _most_within(above: Array) -> Array:
    """The largest sums (s, n) of neighbours among the first 1, 2, … of numbers (s, n); 0 is that of none."""
    sums = np.cumsum(above, axis=-1)
    before = np.minimum.accumulate(np.minimum(sums - above, 0.0), axis=-1)
    return np.maximum(np.maximum.accumulate(sums - before, axis=-1), 0.0)
