"""How much parts of a compound overlap, estimated on lattices of points."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from functools import cache
from typing import NamedTuple

import numpy as np

from graspdsl.arrays import Array, Flags
from graspdsl.objects.compound import Placed

LINES, POINTS = 400, 20  # of a lattice, and on each of its lines
NOTABLE = 0.05  # of the smaller part


class Overlap(NamedTuple):
    """Two parts by their numbers, and the volume within both over that of the smaller one."""

    first: int
    second: int
    share: float


def overlaps(parts: Sequence[Placed]) -> Iterator[Overlap]:
    """The pairs that share more than NOTABLE of the smaller part, one after the other, for each takes its time.

    Of pairs whose bounding boxes meet, the smaller part's own box is cut down to what the other reaches of it and
    filled with LINES × POINTS points: exact for two boxes side by side, else good to one or two hundredths. Boxes,
    cylinders and spheres hold the points that they hold in truth; a mesh holds those its mass is counted for: all in
    its convex hull where it has holes, those within its triangles where it is closed.
    """
    axes = np.eye(3)
    high = np.array([[part.support(axis) for axis in axes] for part in parts])
    low = np.array([[-part.support(-axis) for axis in axes] for part in parts])
    meet = ((low[:, None] < high[None]) & (low[None] < high[:, None])).all(axis=-1)
    volumes = [part.part.solid.volume for part in parts]

    @cache
    def within(number: int) -> Callable[[Array], Flags]:
        return parts[number].part.inside()

    for first, second in np.argwhere(np.triu(meet, 1)).tolist():
        small, large = sorted((first, second), key=lambda number: volumes[number])
        lines, volume = _lattice(parts[small], parts[large])
        if volume > NOTABLE * volumes[small]:
            shared = within(small)(_seen_from(parts[small], lines)) & within(large)(_seen_from(parts[large], lines))
            share = volume * float(shared.mean()) / volumes[small]
            if share > NOTABLE:
                yield Overlap(first, second, min(share, 1.0))


def _lattice(small: Placed, large: Placed) -> tuple[Array, float]:
    """Lines (LINES, POINTS, 3) of points [m] in what both reach along the axes of the first, and its volume [m³]."""
    rotation, at = small.rotation, np.array(small.at)
    high = np.array([min(part.support(axis) for part in (small, large)) for axis in rotation.T]) - at @ rotation
    low = np.array([max(-part.support(-axis) for part in (small, large)) for axis in rotation.T]) - at @ rotation
    size = np.maximum(high - low, 0.0)
    points = low + size * _unit_lattice()
    return points @ rotation.T + at, float(size.prod())


def _unit_lattice() -> Array:
    """Lines (LINES, POINTS, 3) along z of evenly spread points of the unit cube.

    Multiples of powers of 1/g, where g⁴ = g + 1, modulo 1, spread out evenly in three dimensions without standing in
    rows, which round parts would count unevenly.
    """
    ratio = float(max(np.roots([1.0, 0.0, 0.0, -1.0, -1.0]), key=np.real).real)
    starts = np.arange(1, LINES + 1)[:, None] * ratio ** -np.arange(1.0, 4.0) % 1.0
    heights = (np.arange(POINTS) + starts[:, 2:]) / POINTS
    return np.stack([*np.broadcast_arrays(starts[:, :1], starts[:, 1:2], heights)], axis=-1)


def _seen_from(placed: Placed, points: Array) -> Array:
    seen: Array = (points - np.array(placed.at)) @ placed.rotation
    return seen
