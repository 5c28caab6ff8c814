"""The trials of a sweep as one run: those of its first point, then those of the next."""

from __future__ import annotations

from collections.abc import Generator, Iterable, Iterator
from dataclasses import replace

from graspdsl.compiler.program import Program
from graspdsl.trials.loop import OnDrawing, TrialLoop, together
from graspdsl.trials.record import Trial
from graspdsl.trials.setup import trial_loop


class SweepLoop:
    """Runs trials of a sweep, by their numbers in all of it, as :class:`TrialLoop` those of one point: side by side
    while they are of the same point, in a world that is made anew for each."""

    def __init__(self, program: Program) -> None:
        self._program = program
        self._loop: TrialLoop | None = None
        self._next: int | None = None  # of another point than those that run

    @property
    def running(self) -> int:
        """How many trials run now."""
        return self._loop.running if self._loop else 0

    def run_all(
        self, numbers: Iterable[int | None], seed: int, on_drawing: OnDrawing | None = None
    ) -> Generator[Trial, None, None]:
        """Run these trials; each comes as it ends. As :meth:`TrialLoop.run_all`."""
        waiting = iter(numbers)
        while (first := self._next if self._next is not None else next(waiting, None)) is not None:
            self._next = None
            program, own = self._program.of_trial(first)
            offset = first - own
            self._loop = trial_loop(program)
            tell = _told_by(offset, on_drawing) if on_drawing else None
            for trial in self._loop.run_all(self._of_point(first, waiting), seed, tell):
                yield replace(trial, record=replace(trial.record, number=offset + trial.record.number))

    def _of_point(self, first: int, waiting: Iterator[int | None]) -> Iterator[int | None]:
        """The numbers at the point of the first, as they come."""
        each = self._program.spec.trials.count
        number: int | None = first
        while number is None or number // each == first // each:
            yield None if number is None else number % each
            try:
                number = next(waiting)
            except StopIteration:
                return
        self._next = number


def _told_by(offset: int, on_drawing: OnDrawing) -> OnDrawing:
    return lambda number, draws: on_drawing(offset + number, draws)


def loop_over(program: Program) -> TrialLoop | SweepLoop:
    """The loop that runs a program's trials, of a sweep those at all points."""
    return SweepLoop(program) if program.points else trial_loop(program)


def most_together(program: Program) -> int:
    """How many trials of a program may run side by side, at any point of a sweep."""
    return max(map(together, [program.at(point) for point in range(len(program.points))] or [program]))
