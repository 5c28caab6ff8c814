"""CasADi, which makes of the steps of a single tick formulas of numbers, and evaluates these without numpy."""

from __future__ import annotations

import math
import threading
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import accumulate, pairwise
from typing import Any, ClassVar

import numpy as np
import numpy.typing as npt

from graspdsl.arrays import Array
from graspdsl.backends.backend import Backend, Batched, Function, Step
from graspdsl.backends.symbols import Symbols, casadi


class CasADi(Backend):
    """Compiles them to one formula for each number, at their first call; a step that formulas cannot be made of is
    called as it stands, with the numbers that it needs, between what comes before it and what follows."""

    name = "casadi"
    about = "steps compiled to formulas of numbers"
    libraries: ClassVar = {"casadi": "pip install 'graspdsl[casadi]'"}

    def compiled(self, function: Function) -> Batched:
        """Compiled when it is first called."""
        return _Compiled(function)

    def refusal(self, step: Step, *arrays: Array) -> str:
        """It can all."""
        del step, arrays
        return ""


class _Compiled:
    """A function of one trial, compiled for the shapes of its arrays, and called for each trial of a batch."""

    def __init__(self, function: Function) -> None:
        self._function = function
        self._programs: dict[tuple[tuple[int, ...], ...], _Program] = {}

    def __call__(self, batch: tuple[int, ...], *arrays: Array) -> tuple[Array, ...]:
        count = math.prod(batch)
        shapes = tuple(array.shape[len(batch) :] for array in arrays)
        rows = np.concatenate([array.reshape(count, -1) for array in arrays], axis=1, dtype=np.float64)
        if shapes not in self._programs:
            self._programs[shapes] = _traced(self._function, rows[0], arrays, shapes)
        return self._programs[shapes](batch, rows)


class _Rows:
    """What CasADi makes of a column of numbers, row by row: a column of others."""

    def __init__(self, given: Any, made: Any) -> None:
        function = casadi().Function("tick", [given], [casadi().densify(made)], {"cse": True})
        self._given, self._made = np.empty(given.numel()), np.empty(made.numel())
        self._buffer, self._evaluate = function.buffer()
        self._buffer.set_arg(0, memoryview(self._given))
        self._buffer.set_res(0, memoryview(self._made))
        self._alone = threading.Lock()

    def __call__(self, rows: Array) -> Array:
        results = np.empty((len(rows), len(self._made)))
        with self._alone:
            for row, result in zip(rows, results, strict=True):
                self._given[:] = row
                self._evaluate()
                result[:] = self._made
        return results


@dataclass(frozen=True, slots=True)
class _Part:
    """Numbers of a row that are one array: its shape and its type."""

    shape: tuple[int, ...]
    dtype: np.dtype[Any]


class _Parts:
    """Arrays out of rows of numbers (N, n), those of a batch; what are no formulas, as it is."""

    def __init__(self, arrays: Sequence[Symbols | Array]) -> None:
        self._known = tuple(None if isinstance(array, Symbols) else array for array in arrays)
        ...
