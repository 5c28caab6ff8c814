"""Arrays that trials side by side write down tick by tick."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from graspdsl.arrays import Array, Flags, Rows

ROOM = 256  # ticks to begin with
Row = Mapping[str, Array | Flags | float]


class TickRows:
    """Arrays by name, (ticks, N, ...), that grow with the ticks; zeros where nothing was put."""

    def __init__(self, count: int, kind: type[np.floating[Any]]) -> None:
        self._count, self._kind = count, kind
        self._arrays: dict[str, Any] = {}

    def put(self, tick: int, trials: Rows, row: Row) -> None:
        """Write down a tick of some of the trials."""
        for name, values in row.items():
            array = self._arrays.get(name)
            if array is None:
                array = np.zeros((ROOM, self._count, *np.shape(values)[1:]), dtype=self._kind)
            while tick >= len(array):
                array = np.concatenate([array, np.zeros_like(array)])
            array[tick, trials] = values
            self._arrays[name] = array

    def of(self, trial: int, ticks: int) -> dict[str, Any]:
        """The arrays of a trial, (ticks, ...), each on its own."""
        return {name: array[:ticks, trial].copy() for name, array in self._arrays.items()} if ticks else {}
