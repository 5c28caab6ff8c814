"""Whole trials: a start, the course, the grades. Each is a pure function of (program, trial number, seed)."""

from __future__ import annotations

import time
from collections import Counter
from collections.abc import Callable, Generator, Iterable, Sequence
from dataclasses import dataclass, field

import numpy as np

from graspdsl.compiler.program import Program
from graspdsl.quality.grade import CRASHED, NO_CONTACTS
from graspdsl.trials.batches import Alone
from graspdsl.trials.course import Course
from graspdsl.trials.evaluation import Evaluation, Quality
from graspdsl.trials.identity import identities
from graspdsl.trials.logbook import Logbook
from graspdsl.trials.outcomes import Ending, Outcome
from graspdsl.trials.record import RejectedStart, Trial, TrialRecord
from graspdsl.trials.side_by_side import SideBySide
from graspdsl.trials.stages import stages_of
from graspdsl.trials.starts import draws, generator
from graspdsl.worlds.protocol import (
    InfeasibleStartError,
    ManyWorld,
    Start,
    Test,
    UnreachableStartError,
    UnstableObjectError,
    Witness,
    WitnessedWorld,
    WorldCrashError,
)

MOST_DRAWS = 500
TOLD_EACH = 25  # draws
OUT_OF_REACH_EACH, MOST_OUT_OF_REACH = 5, 50  # draws that the arm cannot reach, of an orientation and in all

TRIAL_TICKS = 200_000  # of trials side by side: some 300 MB of floating contacts, if all run to the end of their time
FREE = 1 / 16  # of all places side by side, when others begin there
NOTHING = Logbook([], [])  # of a trial that had no tick

OnDrawing = Callable[[int, int], None]  # number of a trial, draws of a start that it could not take up so far


class NoFeasibleStartError(Exception):
    """The world could take up none of a trial's starts."""

    def __init__(self, rejected: Sequence[RejectedStart]) -> None:
        draws = len(rejected)
        [(reason, count)] = Counter(start.reason for start in rejected).most_common(1)
        share = "" if count == draws else f" ({count} times)"
        none = "the start is not feasible" if draws == 1 else f"no start in {draws} draws was feasible"
        super().__init__(f"{none}: {reason}{share}")


def together(program: Program) -> int:
    """How many trials of a program are best run side by side: as many as its world likes and memory holds. Probes take
    each its own time: trials that probe do not keep step."""
    if program.probes:
        return 1
    ticks = sum(phase.limit for phase in program.spec.program) * program.world.rate
    return min(program.world.together, max(1, round(TRIAL_TICKS / ticks)))


@dataclass(slots=True)
class _Begun:
    """A trial that has begun, or could not."""

    number: int
    identity: str
    start: Start | None = None
    rejected: list[RejectedStart] = field(default_factory=list)
    wall_s: float = 0.0


class TrialLoop:
    """Runs trials of one program on one world, as many side by side as that runs well, of which so many are
    ``running``; a trial has so many draws to find a start."""

    def __init__(self, program: Program, world: WitnessedWorld, most_draws: int = MOST_DRAWS) -> None:
        self._program = program
        self._world: ManyWorld = world if isinstance(world, ManyWorld) else Alone(world)
        self.together = together(program) if isinstance(world, ManyWorld) else 1
        self.running, self._most_draws = 0, most_draws
        self._stages = stages_of(program)
        self._evaluation = Evaluation(program)

    def run(self, number: int, seed: int) -> Trial:
        """Run one trial. What goes wrong in the world is its outcome, not an exception."""
        [trial] = self.run_all([number], seed)
        return trial

    def run_all(
        self, numbers: Iterable[int | None], seed: int, on_drawing: OnDrawing | None = None
    ) -> Generator[Trial, None, None]:
        """Run these trials, ``together`` of them side by side, the next as others end; each comes as it ends, and as it
        were without others.

        numbers: they may come while others run; None where there is none yet, which is asked for again.
        on_drawing: is told now and then how many draws of a start a trial could not take up so far. The wall time of a
        trial beside others is an equal share of that of each tick.
        """
        course = Course(self._program, self._stages, self._world.info, self.together)
        beside = SideBySide(course, self._world, self._graded)
        identity_of, waiting, begun = identities(self._program, seed), iter(numbers), dict[int, _Begun]()
        try:
            while True:
                joined, places = list[_Begun](), beside.free
                if begun and places < self.together * FREE:
                    places = 0
                while len(joined) < places and (number := next(waiting, None)) is not None:
                    trial = _Begun(number, identity_of(number))
                    failure = self._begin(trial, generator(seed, number), on_drawing)
                    if failure is None:
                        joined.append(trial)
                        self.running += 1
                    else:
                        yield self._trial(trial, *self._failed(failure))
                if joined:
                    begun |= dict(zip(beside.begin(len(joined)), joined, strict=True))
                if not begun:
                    return
                for place, ended in beside.tick():
                    trial = begun.pop(place)
                    self.running -= 1
                    trial.wall_s += float(course.wall_s[place])
                    yield self._trial(trial, *ended, course.log, place)
        finally:
            self.running = 0
            self._world.close()

    def _begin(self, trial: _Begun, random: np.random.Generator, on_drawing: OnDrawing | None) -> Exception | None:
        """A trial takes up a start in the world, or says why it cannot."""
        began, failure = time.perf_counter(), None
        try:
            trial.start = self._take_up(trial, random, on_drawing)
        except (NoFeasibleStartError, UnstableObjectError, WorldCrashError) as error:
            failure = error
        trial.wall_s = time.perf_counter() - began
        return failure

    def _take_up(self, trial: _Begun, random: np.random.Generator, on_drawing: OnDrawing | None) -> Start:
        """The first start that the world takes up; those before it are added to the trial's rejected ones."""
        surface, rejected = self._program.robot.hand.palm_surface, trial.rejected
        floats = not self._program.world.has("hand")
        wanted = self._program.spec.trials.start_of(trial.number)
        starts = draws(wanted, self._program.body, surface, random, floats=floats)
        most = 1 if wanted.is_fixed else self._most_draws
        start, beyond = next(starts), 0
        while len(rejected) < most and not beyond == len(rejected) == MOST_OUT_OF_REACH:
            try:
                self._world.join(start, int(random.integers(2**31)))
            except InfeasibleStartError as error:
                rejected.append(RejectedStart(start.drawn, str(error)))
                if on_drawing is not None and len(rejected) % TOLD_EACH == 0:
                    on_drawing(trial.number, len(rejected))
                beyond += isinstance(error, UnreachableStartError)
                start = starts.send(isinstance(error, UnreachableStartError) and beyond % OUT_OF_REACH_EACH == 0)
            else:
                return start
        raise NoFeasibleStartError(rejected)

    def _failed(self, error: Exception) -> tuple[Ending, Quality]:
        """What is said of a trial that an exception ended."""
        if isinstance(error, WorldCrashError):
            return Ending(Outcome.CRASHED, str(error)), self._evaluation.of_nothing(CRASHED)
        outcome = Outcome.TOPPLED if isinstance(error, UnstableObjectError) else Outcome.INFEASIBLE_START
        return Ending(outcome, str(error)), self._evaluation.of_nothing(NO_CONTACTS)

    def _graded(self, _place: int, ending: Ending, witness: Witness | None) -> Test[tuple[Ending, Quality]]:
        """How a trial ended, with the grades of its grasp; to lift the object may end it otherwise."""
        if witness is None:
            return ending, self._evaluation.of_nothing(CRASHED)
        try:
            return ending, (yield from self._evaluation.of(witness, self._program.phases[-1].grasp.contacts))
        except WorldCrashError as error:
            return self._failed(error)

    def _trial(self, trial: _Begun, ending: Ending, quality: Quality, log: Logbook = NOTHING, place: int = 0) -> Trial:
        record = TrialRecord(
            number=trial.number,
            identity=trial.identity,
            outcome=ending.outcome,
            detail=ending.detail,
            start=trial.start.drawn if trial.start else {},
            rejected=tuple(trial.rejected),
            ticks_to_converge=log.ticks_to_converge(place) if ending.outcome is Outcome.CONVERGED else None,
            wall_s=trial.wall_s,
            tare_s=self._world.info.tare_s,
            quality=quality,
            **log.numbers(place),
        )
        return Trial(record, log.trajectory(place))
