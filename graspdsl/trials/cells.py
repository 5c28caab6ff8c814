"""What became of the starts of a grid of two axes: the data of a map of the domain of attraction."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from graspdsl.arrays import Array


@dataclass(frozen=True, slots=True)
class Axis:
    """An axis of a map: equal cells of a parameter from low to high, in its unit."""

    parameter: str
    unit: str
    low: float
    high: float
    cells: int

    @property
    def middles(self) -> Array:
        """The parameter at the middle of each cell, (cells,)."""
        return self.low + (np.arange(self.cells) + 0.5) * (self.high - self.low) / self.cells

    @property
    def said(self) -> str:
        """The axis as ``--over`` takes it."""
        return f"{self.parameter}={self.low!r}:{self.high!r}"


@dataclass(frozen=True, slots=True)
class Cells:
    """A map of n = columns × rows cells, the columns of the first row first.

    outcomes: (n,) by name; orientation [rad] and ticks: (n,), of the grasp at the end and to converge, NaN where there
    is none; details: (n,) what was said of each, maybe nothing. ``x`` and ``y``: the axes of columns and rows.
    ``fixed``: what all starts have in common, in words and with its value; ``marks``: places on the map to show, by
    name.
    """

    x: Axis
    y: Axis
    outcomes: tuple[str, ...]
    orientation: Array
    ticks: Array
    fixed: Mapping[str, str]
    marks: Mapping[str, tuple[float, float]]
    details: tuple[str, ...]
