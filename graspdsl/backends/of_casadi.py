"""CasADi, which makes of the steps of a single tick formulas of numbers, and evaluates these without numpy."""

from __future__ import annotations

import math
import threading
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import accumulate
from typing import Any, ClassVar

import numpy as np

from graspdsl.arrays import Array
from graspdsl.backends.backend import Backend, Batched, Function, Step
from graspdsl.backends.symbols import Symbols, casadi, in_formulas


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
            trace = _Trace(rows[0], [(shape, array.dtype) for shape, array in zip(shapes, arrays, strict=True)])
            self._programs[shapes] = trace.program(self._function)
        return self._programs[shapes](batch, rows)


@dataclass(frozen=True, slots=True)
class _Part:
    """Where in a row the numbers of an array are, its shape and its type."""

    place: slice
    shape: tuple[int, ...]
    dtype: np.dtype[Any]

    def of(self, rows: Array, batch: tuple[int, ...]) -> Array:
        """The array of each trial of a batch."""
        array = rows[:, self.place].reshape(batch + self.shape)
        return array if self.dtype == array.dtype else array.astype(self.dtype)


class _Formulas:
    """Arrays as CasADi makes them of numbers known before, those of one trial in a row; what of them are no symbols, is
    as it is."""

    def __init__(self, known: Any, arrays: Sequence[Symbols | Array]) -> None:
        made = casadi().vertcat(*(array.elements for array in arrays if isinstance(array, Symbols)))
        function = casadi().Function("made", [known], [made], {"cse": True})
        self._given, self._made, self._alone = np.empty(known.numel()), np.empty(made.numel()), threading.Lock()
        self._buffer, self._evaluate = function.buffer()
        self._buffer.set_arg(0, self._given.data)
        self._buffer.set_res(0, self._made.data)
        ends = accumulate(array.size if isinstance(array, Symbols) else 0 for array in arrays)
        self._arrays = [
            _Part(slice(end - array.size, end), array.shape, array.dtype) if isinstance(array, Symbols) else array
            for array, end in zip(arrays, ends, strict=True)
        ]

    def __call__(self, batch: tuple[int, ...], rows: Array) -> tuple[Array, ...]:
        made = np.empty((len(rows), len(self._made)))
        with self._alone:
            for row, result in zip(rows, made, strict=True):
                self._given[:] = row
                self._evaluate()
                result[:] = self._made
        return tuple([part.of(made, batch) if isinstance(part, _Part) else part for part in self._arrays])


@dataclass(frozen=True, slots=True)
class _Call:
    """A step that is called as it stands: what it is given, and the shape of what it makes of one trial."""

    step: Step
    given: _Formulas
    shape: tuple[int, ...]

    def __call__(self, batch: tuple[int, ...], rows: Array) -> Array:
        """The rows with what it makes of each behind them."""
        made = np.broadcast_to(self.step(*self.given(batch, rows)), (*batch, *self.shape))
        return np.concatenate([rows, made.reshape(len(rows), -1)], axis=1)


@dataclass(frozen=True, slots=True)
class _Program:
    """The steps that are called, each with formulas of what is known before it, and formulas of all that is wanted."""

    calls: Sequence[_Call]
    wanted: _Formulas

    def __call__(self, batch: tuple[int, ...], rows: Array) -> tuple[Array, ...]:
        for call in self.calls:
            rows = call(batch, rows)
        return self.wanted(batch, rows)


class _Trace:
    """A function as it is called with symbols in place of the numbers of a row."""

    def __init__(self, row: Array, arrays: Sequence[tuple[tuple[int, ...], np.dtype[Any]]]) -> None:
        self._row, self._known, self._calls = row, casadi().SX.sym("given", len(row)), list[_Call]()
        ends = accumulate(math.prod(shape) for shape, _ in arrays)
        self._given = [
            Symbols(self._known, np.arange(end - math.prod(shape), end).reshape(shape), dtype)
            for (shape, dtype), end in zip(arrays, ends, strict=True)
        ]

    def program(self, function: Function) -> _Program:
        """What the function does, for any numbers."""
        wanted = [in_formulas(array) for array in function(self._call, *self._given)]
        return _Program(self._calls, _Formulas(self._known, wanted))

    def _call(self, step: Step, *arrays: Any) -> Any:
        """What a step makes of arrays, some of symbols."""
        if not any(isinstance(array, Symbols) for array in arrays):
            return np.asarray(step(*arrays))
        try:
            made = step(*arrays)
            return made if isinstance(made, Symbols) else np.asarray(made)
        except Exception:  # whatever it comes to: with numbers it does as it would without a compiler
            return self._called(step, arrays)

    def _called(self, step: Step, arrays: Sequence[Any]) -> Symbols:
        """Symbols for what a step makes of numbers."""
        given = _Formulas(self._known, arrays)
        made = np.asarray(step(*given((), self._row[None])))
        unknown = casadi().SX.sym("made", made.size)
        self._calls.append(_Call(step, given, made.shape))
        self._row, self._known = np.append(self._row, made), casadi().vertcat(self._known, unknown)
        return Symbols(unknown, np.arange(made.size).reshape(made.shape), made.dtype)
