"""Trials side by side in a world, and what comes after the end of each; others take the places of those that are over.

What many share of a tick, the calls of Python and numpy, hardly depends on how many they are: it is worth keeping a
batch full.
"""

from __future__ import annotations

import functools
import time
from collections.abc import Callable, Iterator
from typing import Generic

import numpy as np

from graspdsl.arrays import Rows
from graspdsl.trials.batches import of_rows
from graspdsl.trials.course import Course
from graspdsl.trials.outcomes import Ending, Outcome
from graspdsl.worlds.protocol import (
    Command,
    Found,
    ManyWorld,
    Observation,
    Shown,
    Test,
    Truth,
    Witness,
    WorldCrashError,
)

After = Callable[[int, Ending, Witness | None], Test[Found]]
"""What comes after the end of a trial, by its place and its ending: with who knows what its grasp is like then, nobody
where the world failed."""


def over(_place: int, ending: Ending, witness: Witness | None) -> Test[tuple[Ending, Witness | None]]:
    """Nothing comes after."""
    yield from ()
    return ending, witness


class SideBySide(Generic[Found]):
    """The trials of a course in a world, and what comes after the end of each beside those that still run."""

    def __init__(self, course: Course, world: ManyWorld, after: After[Found]) -> None:
        self._course, self._world, self._after, self._tests = course, world, after, _Tests[Found]()
        self._places = np.zeros(0, dtype=np.intp)  # of trials, by the rows of the world
        self._command: Command | None = None

    @property
    def free(self) -> int:
        """At how many places there is none."""
        return self._course.room - len(self._places)

    def begin(self, count: int) -> list[int]:
        """So many have joined the world, one after the other: they begin at these places."""
        places: Rows = np.setdiff1d(np.arange(self._course.room), self._places)[:count]
        self._places = np.concatenate([self._places, places])
        self._course.begin(places)
        return [int(place) for place in places]

    def run(self) -> Iterator[tuple[int, Found]]:
        """Go on until all are over: what :meth:`tick` returns, one after the other."""
        while len(self._places):
            yield from self.tick()

    def tick(self) -> list[tuple[int, Found]]:
        """Go on with all for a tick. Returns what is over by it: places, and what was found of each. What the course
        knows of these it knows until others begin there."""
        began, places, tests = time.perf_counter(), self._places, self._tests
        try:
            seen = self._world.observe() if self._command is None else self._world.step(self._command)
            self._command = self._turn(seen, self._world.truth())
        except WorldCrashError as error:
            self._command = None
            crashed = error.crashed or dict.fromkeys(range(len(places)), str(error))
            for place, said in ((int(places[row]), said) for row, said in sorted(crashed.items())):
                if place in tests.running:
                    tests.end(place, WorldCrashError(said))
                else:
                    tests.begin(place, self._after(place, Ending(Outcome.CRASHED, said), None))
            self._course.leave(places[list(crashed)])
        self._course.wall_s[places] += (time.perf_counter() - began) / len(places)
        found = sorted(tests.found.items())
        if found:
            tests.found.clear()
            self._keep(np.flatnonzero(~np.isin(places, [place for place, _ in found])))
        return found

    def _keep(self, rows: Rows) -> None:
        """Go on with these alone."""
        self._places = self._places[rows]
        self._world.keep(rows)
        command, self._command = self._command, None
        if command is not None and len(rows):
            self._command = Command(command.space, command.displacement[rows])

    def _turn(self, seen: Observation, truth: Truth) -> Command | None:
        """What follows from a tick: the command of all rows; None where all are over."""
        places, tests = self._places, self._tests
        running = np.ones(len(places), dtype=bool)
        if tests.running:
            running = np.isin(places, self._course.trials)
            for row in np.flatnonzero(~running).tolist():
                tests.show(int(places[row]), (seen.row(row), truth.row(row)))
        given = list[Command]()
        chosen = np.flatnonzero(running)
        if len(chosen):
            turns = self._course.tick(of_rows(seen, chosen, len(places)), of_rows(truth, chosen, len(places)))
            for place, ending in sorted(turns.endings.items()):
                row = int(chosen[place])
                tests.begin(int(places[row]), self._after(int(places[row]), ending, self._world.witness(row)))
            if len(chosen) == len(places) and not tests.commands:
                return turns.command
            given += [turns.command] if len(self._course.trials) else []
        given += tests.commands.values()
        if not given:
            return None
        displacement = np.zeros((len(places), given[0].displacement.shape[-1]))
        if len(self._course.trials):
            displacement[running] = given[0].displacement
        for place, command in tests.commands.items():
            displacement[places == place] = command.displacement
        return Command(given[0].space, displacement)


class _Tests(Generic[Found]):
    """What is done with trials after their end, by their places: the tests that are ``running``, the ``commands`` that
    they gave last, and what was ``found`` by those that are over."""

    def __init__(self) -> None:
        self.running: dict[int, Test[Found]] = {}
        self.commands: dict[int, Command] = {}
        self.found: dict[int, Found] = {}

    def begin(self, place: int, test: Test[Found]) -> None:
        """The first command of a test."""
        self._go_on(place, test, functools.partial(next, test))

    def show(self, place: int, shown: Shown) -> None:
        """What has come of the last command, for the next."""
        test = self.running[place]
        self._go_on(place, test, functools.partial(test.send, shown))

    def end(self, place: int, error: WorldCrashError) -> None:
        """The last command could not be carried out, nor can any other."""
        test = self.running[place]
        while place in self.running:
            self._go_on(place, test, functools.partial(test.throw, error))

    def _go_on(self, place: int, test: Test[Found], ask: Callable[[], Command]) -> None:
        try:
            self.commands[place], self.running[place] = ask(), test
        except StopIteration as end:
            self.found[place] = end.value
            self.running.pop(place, None)
            self.commands.pop(place, None)
