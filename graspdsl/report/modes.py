"""The modes of end orientations: how many there are, where they part, and how sure their shares are.

A sample has a second mode where two intervals hold more of it than one does (:mod:`graspdsl.report.excess_mass`), by
more than hardly ever in samples of its own density made to have one mode; it then parts, and each part is asked in
turn. To test against one's own density is M.-Y. Cheng's and P. Hall's idea (J. R. Stat. Soc. B 60:579, 1998). How often
this rule errs: docs/modes.md.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from graspdsl.arrays import Array, Flags, Rows
from graspdsl.report.excess_mass import CELLS, cells_of, counted_in, edges, excess_mass, smoothed
from graspdsl.report.statistics import (
    BOOTSTRAP_SEED,
    FEWEST,
    RESAMPLES,
    Interval,
    bandwidth,
    percentile_interval,
    wilson,
)

LEVEL = 0.01  # of the test; the density follows the sample, so that more samples of one mode than this seem to have two
SAMPLES, AT_ONCE = 1000, 100  # of the density with one mode
FINE = 512  # cells that a peak is sought in


@dataclass(frozen=True, slots=True)
class Mode:
    """A mode of angles [rad]: its peak, the range it covers and the values in it, by position."""

    centre: float
    low: float
    high: float
    members: tuple[int, ...]


@dataclass(frozen=True, slots=True)
class Part:
    """Cells of a histogram, from the first up to the last, and the two parts that they fall into, if they do."""

    first: int
    last: int
    parts: tuple[Part, ...] = ()

    @property
    def leaves(self) -> tuple[Part, ...]:
        """The parts that have none, in order."""
        return tuple(leaf for part in self.parts for leaf in part.leaves) or (self,)


def modes(values: Array) -> list[Mode]:
    """The modes of angles (n,) in 0…π/2, largest first. Fewer than FEWEST angles have one."""
    if len(values) == 0:
        return []
    cells = cells_of(values)
    found = []
    for part in _parted(counted_in(values)).leaves:
        members = np.flatnonzero((cells >= part.first) & (cells < part.last))
        peak = np.argmax(smoothed(counted_in(values[members], FINE), bandwidth(values[members])))
        centre = edges(FINE)[peak : peak + 2].mean()
        low, high = edges()[[part.first, part.last]]
        found.append(Mode(float(centre), float(low), float(high), tuple(members.tolist())))
    return sorted(found, key=lambda mode: -len(mode.members))


def share_intervals(values: Array, found: Sequence[Mode]) -> list[Interval]:
    """The 95 % intervals of the shares of the modes that :func:`modes` found in angles (n,).

    Given that there are so many, where they part was chosen from the sample: each of RESAMPLES drawn from it is parted
    anew, as often, where that is best. To a mode falls what is in one range with its peak; of two modes in one range,
    to the larger. Never narrower than Wilson's interval, which takes the ranges as given.
    """
    fixed = [wilson(len(mode.members), len(values)) for mode in found]
    if len(found) < 2:
        return fixed
    counts = counted_in(values)
    drawn = np.random.default_rng(BOOTSTRAP_SEED).multinomial(len(values), counts / len(values), size=RESAMPLES)
    begins = np.zeros(drawn.shape, dtype=bool)
    _part_alike(drawn, _parted(counts), begins)
    ranges = np.cumsum(begins, axis=-1)
    of_modes = ranges[:, cells_of(np.array([mode.centre for mode in found]))]
    intervals = []
    for rank, (low, high) in enumerate(fixed):
        own = of_modes[:, rank, None]
        shares = np.where(ranges == own, drawn, 0).sum(axis=-1) / len(values)
        shares[(of_modes[:, :rank] == own).any(axis=-1)] = 0.0
        least, most = percentile_interval(shares)
        intervals.append((min(low, least), max(high, most)))
    return intervals


def of_one_mode(density: Array) -> Array:
    """The density with one mode that is nearest to one (n,) on both sides of its highest peak, in mean square."""
    from scipy.optimize import isotonic_regression

    peak = int(np.argmax(density))
    rising, falling = isotonic_regression(density[: peak + 1]), isotonic_regression(density[peak:], increasing=False)
    return np.concatenate([rising.x[:-1], falling.x])


def _parted(counts: Rows, first: int = 0, last: int = CELLS) -> Part:
    own = np.zeros_like(counts)
    own[first:last] = counts[first:last]
    excess, begins = excess_mass(own[None])
    if own.sum() < FEWEST or not _is_shown(float(excess[0]), own):
        return Part(first, last)
    cell = int(begins[0])
    return Part(first, last, (_parted(counts, first, cell), _parted(counts, cell, last)))


def _is_shown(excess: float, counts: Rows) -> bool:
    """Whether no more than a share LEVEL of samples of a histogram's density, made to have one mode, have as much."""
    values = np.repeat(edges()[:-1], counts)
    law = np.maximum(of_one_mode(smoothed(counts, bandwidth(values))), 0.0)
    random, as_much = np.random.default_rng(BOOTSTRAP_SEED), 0
    for _ in range(SAMPLES // AT_ONCE):
        drawn = random.multinomial(counts.sum(), law / law.sum(), size=AT_ONCE)
        as_much += int(np.count_nonzero(excess_mass(drawn)[0] >= excess))
        if as_much > LEVEL * SAMPLES:
            return False
    return True


def _part_alike(counts: Rows, like: Part, begins: Flags) -> None:
    """Part other histograms (s, CELLS) as often as one was; where a mode begins is entered."""
    if not like.parts:
        return
    _, cells = excess_mass(counts)
    begins[np.arange(len(counts)), cells] = True
    above = np.arange(CELLS) >= cells[:, None]
    for part, side in zip(like.parts, (~above, above), strict=True):
        _part_alike(np.where(side, counts, 0), part, begins)
