"""Many trials and one: what is of some of those side by side, and one as if it were many."""

from __future__ import annotations

import dataclasses
from typing import Any, TypeVar

import numpy as np

from graspdsl.arrays import Rows
from graspdsl.compiler.pipeline import Ticks
from graspdsl.worlds.protocol import Command, Observation, Start, Truth, Witness, WitnessedWorld

Batch = TypeVar("Batch", Observation, Truth, Ticks)


def of_rows(whole: Batch, rows: Rows, count: int) -> Batch:
    """What of an observation, a truth or ticks of so many trials is of these rows, in order."""
    if len(rows) == count:
        return whole
    parts: dict[str, Any] = {field.name: getattr(whole, field.name) for field in dataclasses.fields(whole)}
    for name, value in parts.items():
        if isinstance(value, tuple):
            parts[name] = tuple(value[row] for row in rows)
        elif isinstance(value, np.ndarray):
            parts[name] = value[rows]
    return dataclasses.replace(whole, **parts)


class Alone:
    """A world of one trial as one of many: with a leading axis of one."""

    def __init__(self, world: WitnessedWorld) -> None:
        self.world, self.info = world, world.info
        self._seen: Observation | None = None

    def join(self, start: Start, seed: int) -> None:
        """The one trial takes up its start."""
        self._seen = self.world.reset(start, seed)

    def observe(self) -> Observation:
        """What it sensed then."""
        assert self._seen is not None
        return led(self._seen)

    def step(self, command: Command) -> Observation:
        """Carry out its command."""
        return led(self.world.step(Command(command.space, command.displacement[0])))

    def truth(self) -> Truth:
        """The world's."""
        return led(self.world.truth())

    def witness(self, row: int) -> Witness:
        """The world itself."""
        del row
        return self.world

    def keep(self, rows: Rows) -> None:
        """There is no other."""

    def close(self) -> None:
        """As of the world."""
        self.world.close()


def led(alone: Batch) -> Batch:
    """What is of one trial, with a leading axis."""
    parts: dict[str, Any] = {field.name: getattr(alone, field.name) for field in dataclasses.fields(alone)}
    for name, part in parts.items():
        parts[name] = (part,) if isinstance(part, tuple) else np.asarray(part)[None]
    return dataclasses.replace(alone, **parts)
