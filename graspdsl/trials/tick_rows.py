"""Arrays that trials side by side write down tick by tick."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Iterator, Mapping
from typing import Any, NamedTuple

import numpy as np

from graspdsl.arrays import Array, Flags, Rows
from graspdsl.compiler.pipeline import Ticks
from graspdsl.trials.measures import GraspMeasure
from graspdsl.worlds.protocol import Observation, Truth

ENOUGH = 64  # rows, a tick of a trial each, that are worked on at once: more would be no faster
Row = Mapping[str, Array | Flags]


class TickRows:
    """Arrays by name, (ticks, N, ...), of so many trials and ticks, or more where there are; zeros where nothing was
    put. They take of memory what was put."""

    def __init__(self, count: int, ticks: int, kind: type[np.floating[Any]]) -> None:
        self._count, self._ticks, self._kind = count, ticks, kind
        self._arrays: dict[str, Any] = {}

    def put(self, tick: Rows, trials: Rows, row: Row) -> None:
        """Write down T ticks, (T, M, ...), of M of the trials, for each from one (M,) on."""
        count = len(next(iter(row.values())))
        at, end = tick + np.arange(count)[:, None], int(tick.max()) + count
        for name, values in row.items():
            array = self._arrays.get(name)
            if array is None:
                array = np.zeros((self._ticks, self._count, *np.shape(values)[2:]), dtype=self._kind)
            while end > len(array):
                array = np.concatenate([array, np.zeros_like(array)])
            array[at, trials] = values
            self._arrays[name] = array

    def clear(self, trials: Rows, ticks: int) -> None:
        """Zeros again in the first of the ticks."""
        for array in self._arrays.values():
            array[:ticks, trials] = 0.0

    def of(self, trial: int, ticks: int) -> dict[str, Any]:
        """The arrays of a trial, (ticks, ...), each on its own."""
        return {name: array[:ticks, trial].copy() for name, array in self._arrays.items()} if ticks else {}


class Told(NamedTuple):
    """What is told of a tick: all with leading axes, (M, ...) of M trials, or (T, M, ...) of them in T ticks."""

    seen: Observation
    truth: Truth
    ticks: Ticks
    now: GraspMeasure


class Ahead:
    """What is told of trials tick by tick, kept until it is worth working on: ``write`` gets the first (M,) of T
    ticks in a row of each of M trials, their phase and stage, and what is told of them. Of few trials there are many
    ticks, of many trials one.
    """

    def __init__(self, write: Callable[[Rows, Rows, int, int, Told], None]) -> None:
        self._write = write
        self._first, self._trials = np.zeros((2, 0), dtype=np.intp)
        self._ticks, self._place = 0, (0, 0)
        self._last: Told | None = None
        self._rooms: list[dict[str, Any]] = []  # of each part of what is told, by the names of its arrays

    def tell(self, tick: Rows, trials: Rows, phase: int, stage: int, told: Told) -> None:
        """A tick of M of the trials, by the number (M,) that it has for each."""
        if len(trials) >= ENOUGH:
            self.write()
            one = Told(*(_with(part, {name: array[None] for name, array in _arrays(part)}) for part in told))
            self._write(tick, trials, phase, stage, one)
            return
        same = (phase, stage) == self._place and np.array_equal(trials, self._trials)
        if not (same and np.array_equal(tick, self._first + self._ticks)):
            self.write()
            self._first, self._trials, self._place = tick, trials, (phase, stage)
            room = ENOUGH // len(trials)
            self._rooms = [
                {name: np.empty((room, *array.shape), array.dtype) for name, array in _arrays(part)} for part in told
            ]
        for part, rooms in zip(told, self._rooms, strict=True):
            for name, filled in rooms.items():
                filled[self._ticks] = getattr(part, name)
        self._ticks, self._last = self._ticks + 1, told
        if (self._ticks + 1) * len(trials) > ENOUGH:
            self.write()

    def write(self) -> None:
        """Have written what was told so far."""
        if self._last is not None:
            first, count, last = self._first, self._ticks, self._last
            self._first, self._ticks, self._last = first + count, 0, None
            told = (
                _with(part, {name: filled[:count] for name, filled in rooms.items()})
                for part, rooms in zip(last, self._rooms, strict=True)
            )
            self._write(first, self._trials, *self._place, Told(*told))


def _arrays(part: Any) -> Iterator[tuple[str, Any]]:
    """What of an observation, a truth, ticks or a measure is numbers, by name."""
    for field in dataclasses.fields(part):
        value = getattr(part, field.name)
        if isinstance(value, np.ndarray | float):
            yield field.name, np.asarray(value)


def _with(part: Any, arrays: Mapping[str, Any]) -> Any:
    return dataclasses.replace(part, **arrays)
