"""Statistics of a run: intervals of shares, densities on a bounded range, their separation into modes."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from graspdsl.arrays import Array

LEAST_BANDWIDTH = 0.05  # rad; what the chapter's figures still resolve
RIGHT_ANGLE = math.pi / 2


def wilson(successes: int, count: int, z: float = 1.959963984540054) -> tuple[float, float]:
    """The Wilson score interval of a share, 95 % by default; (0, 1) when nothing was counted."""
    if count == 0:
        return 0.0, 1.0
    share = successes / count
    spread = z * math.sqrt(share * (1 - share) / count + z * z / (4 * count * count))
    middle, scale = share + z * z / (2 * count), 1 + z * z / count
    return max(0.0, (middle - spread) / scale), min(1.0, (middle + spread) / scale)


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


@dataclass(frozen=True, slots=True)
class Mode:
    """A mode of the end orientations [rad]: its peak, the range it covers and the trials in it, by position."""

    centre: float
    low: float
    high: float
    members: tuple[int, ...]


def modes(values: Array) -> list[Mode]:
    """The modes of angles in 0…π/2, largest first: the density's peaks, parted at the lowest points between them.

    A peak that hardly rises above the valley beside it (less than a tenth of it) belongs to its neighbour.
    """
    if len(values) == 0:
        return []
    grid = np.linspace(0.0, RIGHT_ANGLE, 513)
    heights = density(values, grid, bandwidth(values))
    rising = np.diff(heights, prepend=-np.inf) > 0
    falling = np.diff(heights, append=-np.inf) <= 0  # two equal heights are one peak
    peaks = list(np.flatnonzero(rising & falling))
    while len(peaks) > 1:
        valleys = [int(a + np.argmin(heights[a : b + 1])) for a, b in pairwise(peaks)]
        drops = [min(heights[a], heights[b]) / heights[v] for a, b, v in zip(peaks, peaks[1:], valleys, strict=False)]
        weakest = int(np.argmin(drops))
        if drops[weakest] >= 1.1:
            break
        left, right = peaks[weakest], peaks[weakest + 1]
        peaks.remove(left if heights[left] < heights[right] else right)
    cuts = [grid[int(a + np.argmin(heights[a : b + 1]))] for a, b in pairwise(peaks)]
    edges = [0.0, *cuts, np.inf]
    found = []
    for peak, low, high in zip(peaks, edges, edges[1:], strict=False):
        members = tuple(int(i) for i in np.flatnonzero((values >= low) & (values < high)))
        if members:
            found.append(Mode(float(grid[peak]), float(low), float(min(high, RIGHT_ANGLE)), members))
    return sorted(found, key=lambda mode: -len(mode.members))
