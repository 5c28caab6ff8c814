"""Processes that share the trials of a run. One that dies costs the run the trials that kill it, and no others.

Which of the trials side by side killed a process nobody knows. So each of them is run again by itself, in a process of
its own; one that kills that, too, has crashed.
"""

from __future__ import annotations

import functools
import itertools
import math
import multiprocessing
import multiprocessing.connection
import multiprocessing.process
import os
import signal
import sys
import threading
import time
import traceback
from collections import Counter, deque
from collections.abc import Callable, Generator, Iterator, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field
from multiprocessing import resource_tracker
from types import ModuleType
from typing import NamedTuple

from graspdsl.compiler.program import Source, program_of
from graspdsl.plugins.answering import answered_for
from graspdsl.trials.interruption import SIGNALS, interruption
from graspdsl.trials.loop import OnDrawing
from graspdsl.trials.record import PackedTrial
from graspdsl.trials.sweeps import loop_over

ENGINES = ("local", "dask")
AHEAD = 8  # trials that a worker knows of besides those it runs, so that it need not wait for the next
GLANCE = 0.5  # s
RUNS = 2  # of a trial that kills its worker
FRUITLESS = 10  # workers that may die one after the other before any trial is finished
GROWN, SPARE = 2.0, 256e6  # one that needs more than so many times, and bytes, of what it did at first is replaced
_STOPPED = {getattr(signal, name, None) for name in ("SIGKILL", "SIGTERM", "SIGINT", "SIGHUP")}

OnCrash = Callable[[int, str], PackedTrial]  # what is kept of a trial, by its number, and of what ended it each time


@dataclass(frozen=True, slots=True)
class Dask:
    """A Dask cluster: that of a scheduler, by its address or its file (.json), or one of so many processes on this
    machine, by default as many as are worth it."""

    scheduler: str | None = None
    workers: int | None = None


Workers = int | Dask | None  # who shares the trials: so many processes, by default as many as are worth it, or Dask's


def sharing(workers: int | None, engine: str, scheduler: str | None) -> Workers:
    """Who shares the trials of a run, as its user names them: engine ``local`` or ``dask``. Raises ValueError where
    that does not go together."""
    if engine not in ENGINES:
        raise ValueError(f"engine: expected {' or '.join(ENGINES)}, found {engine!r}")
    if scheduler is None:
        return workers if engine == "local" else Dask(workers=workers)
    if engine == "local":
        raise ValueError("a scheduler is one of Dask's: ask for the engine dask, too")
    if workers is not None:
        raise ValueError("a scheduler has workers of its own: give one of the two")
    return Dask(scheduler)


def too_long(limit: float) -> str:
    """What ended a process whose trials took longer than they may, [s] each."""
    return f"after more than {limit:g} s, trials.wall_limit"


class WorkerEndedError(Exception):
    """Worker processes end before any trial does; ``from_outside`` when somebody or the system stops them, or may have
    done so."""

    def __init__(self, cause: str, exit_code: int | None) -> None:
        self.from_outside = exit_code is None or -exit_code in _STOPPED
        advice = "; if memory is short, fewer --workers need less" if exit_code == -signal.SIGKILL else ""
        super().__init__(f"{FRUITLESS} worker processes ended one after the other ({cause}){advice}")


class Finished(NamedTuple):
    """A trial has ended; ``memory``: the most that its process has needed so far [bytes], 0 where that is not told."""

    trial: PackedTrial
    memory: float


class Drawing(NamedTuple):
    """A trial looks for a start, as of OnDrawing."""

    number: int
    draws: int


class Ready(NamedTuple):
    """A process has made its world."""


class Retired(NamedTuple):
    """A process has ended its trials and begins no more, since it needs much more memory than it did."""


Message = Finished | Drawing | Ready | Retired
Process = multiprocessing.process.BaseProcess
Pipe = multiprocessing.connection.Connection  # numbers of trials to a worker; to here messages, or an exception


def _work(pipe: Pipe, source: Source, seed: int) -> None:
    """What a worker process does, until it is killed or needs much more memory than it did."""
    threading.Thread(target=_end_with_parent, daemon=True).start()
    enough = math.inf

    def asked_for() -> Iterator[int | None]:
        """The numbers of trials; None where there is none now, and others run meanwhile."""
        while _memory() <= enough:
            if loop.running and not pipe.poll():
                yield None
            else:
                yield from pipe.recv()

    try:
        program = program_of(*source)
        with answered_for(program.plugins):
            loop, keep = loop_over(program), program.spec.trials.keep
            pipe.send(Ready())
            for trial in loop.run_all(asked_for(), seed, functools.partial(_tell, pipe)):
                pipe.send(Finished(trial.packed(keep), _memory()))
                enough = min(enough, GROWN * _memory() + SPARE)
            pipe.send(Retired())
    except Exception as error:
        error.add_note("".join(traceback.format_exception(error)))  # where it was, which does not travel by itself
        with suppress(OSError):  # nobody is there any more
            pipe.send(error)


def _tell(pipe: Pipe, number: int, draws: int) -> None:
    pipe.send(Drawing(number, draws))


def _memory() -> float:
    """The most memory that this process has needed so far [bytes]; 0 where the system does not tell."""
    try:
        import resource
    except ImportError:
        return 0.0
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * (1.0 if sys.platform == "darwin" else 1024.0)


def _end_with_parent() -> None:
    """Should the parent of a worker be killed in the middle of a trial, nobody else would end it."""
    parent = multiprocessing.parent_process()
    if parent is not None:
        parent.join()
        os._exit(1)


@dataclass(slots=True)
class _Worker:
    """A process, and the numbers of the trials that it knows of and has not finished, in the order in which it begins
    them.

    ``heard``: when it last said something [s]; ``memory``: the most that it has told of [bytes]; ``is_late``: whether
    it was killed since it said nothing for too long.
    """

    process: Process
    numbers: list[int] = field(default_factory=list)
    is_ready: bool = False
    heard: float = field(default_factory=time.monotonic)
    memory: float = 0.0
    is_late: bool = False


class Crew:
    """So many workers, each of which runs so many trials ``together``. ``limit`` [s]: of wall time that a trial may
    take by itself."""

    def __init__(
        self,
        source: Source,
        seed: int,
        workers: int,
        together: int,
        limit: float,
        on_drawing: OnDrawing,
        on_crash: OnCrash,
    ) -> None:
        self._source, self._seed, self._count, self._together = source, seed, workers, together
        self._limit, self._tell, self._crashed = limit, on_drawing, on_crash
        self._workers: dict[Pipe, _Worker] = {}
        self._left: Iterator[int] = iter(())
        self._suspects: deque[int] = deque()  # trials whose worker ended
        self._ends: Counter[int] = Counter()  # of workers, by the trials that they were at
        self._fruitless = 0

    def run(self, numbers: Sequence[int]) -> Generator[PackedTrial, None, None]:
        """Run these trials; each comes as it ends.

        Raises WorkerEndedError where workers die one after the other, and what goes wrong in one without ending it.
        """
        self._left, waiting = iter(numbers), len(numbers)
        share = min(math.ceil(len(numbers) / self._count), self._together + AHEAD)
        with interruption.at_the_end(self._kill):
            while waiting:
                self._give(share)
                # A signal just before a wait is heeded after it.
                heard = multiprocessing.connection.wait(list(self._workers), timeout=GLANCE)
                for pipe in set(self._workers).intersection(heard):
                    for trial in self._heard(pipe):
                        waiting -= 1
                        yield trial
                self._kill_late()

    def _give(self, share: int) -> None:
        """Let as many work as there are workers, and each know of so many trials; one that is at a suspect, of no
        other."""
        while len(self._workers) < self._count and (more := self._next(share, begins=True)):
            with interruption.whole():
                pipe, process = _started(self._source, self._seed)
                self._workers[pipe] = _Worker(process)
            self._send(pipe, more)
        for pipe, worker in self._workers.items():
            count, alone = share - len(worker.numbers), not self._ends.keys().isdisjoint(worker.numbers)
            if count and not alone and (more := self._next(count, begins=not worker.numbers)):
                self._send(pipe, more)

    def _next(self, count: int, *, begins: bool) -> list[int]:
        """So many trials for a worker, if there are as many left; a suspect for one that ``begins``, if there is."""
        return [self._suspects.popleft()] if begins and self._suspects else list(itertools.islice(self._left, count))

    def _send(self, pipe: Pipe, numbers: list[int]) -> None:
        self._workers[pipe].numbers += numbers
        with suppress(OSError):  # that it has ended is found when its trials are awaited
            pipe.send(numbers)

    def _heard(self, pipe: Pipe) -> Iterator[PackedTrial]:
        worker = self._workers[pipe]
        try:
            message: Message | Exception = pipe.recv()
        except (EOFError, OSError):
            yield from self._ended(pipe)
            return
        worker.heard = time.monotonic()
        match message:
            case Exception():
                raise message
            case Drawing(number, draws):
                self._tell(number, draws)
            case Finished(trial, memory):
                worker.memory, self._fruitless = memory, 0
                worker.numbers.remove(trial.record.number)
                yield trial
            case Ready():
                worker.is_ready = True
            case Retired():
                self._left = itertools.chain(self._buried(pipe).numbers, self._left)

    def _ended(self, pipe: Pipe) -> Iterator[PackedTrial]:
        """What becomes of the trials of a worker that has ended."""
        worker = self._buried(pipe)
        running = self._running(worker)
        self._left = itertools.chain(worker.numbers[len(running) :], self._left)
        self._fruitless += 1
        if self._fruitless == FRUITLESS:
            raise WorkerEndedError(self._cause(worker), worker.process.exitcode)
        for number in running:
            self._ends[number] += 1
            if self._ends[number] < RUNS:
                self._suspects.append(number)
            else:
                yield self._crashed(number, self._cause(worker))

    def _running(self, worker: _Worker) -> list[int]:
        """The trials that a worker may be at."""
        return worker.numbers[: self._together] if worker.is_ready else []

    def _buried(self, pipe: Pipe) -> _Worker:
        worker = self._workers.pop(pipe)
        worker.process.join(timeout=GLANCE)
        pipe.close()
        return worker

    def _cause(self, worker: _Worker) -> str:
        """What is known of how a worker ended."""
        if worker.is_late:
            return too_long(self._limit)
        code = worker.process.exitcode
        said = "no exit code" if code is None else f"exit code {code}" if code >= 0 else signal.Signals(-code).name
        return f"{said}, with {worker.memory / 1e6:.0f} MB" if worker.memory else said

    def _kill_late(self) -> None:
        """Kill workers that have said nothing for longer than all trials that they are at may take."""
        now = time.monotonic()
        for worker in self._workers.values():
            running = self._running(worker)
            if running and now - worker.heard > self._limit * len(running):
                worker.is_late = True
                worker.process.kill()

    def _kill(self) -> None:
        """Nobody waits for the trials that are still running."""
        for worker in self._workers.values():
            worker.process.kill()
        for pipe in list(self._workers):
            self._buried(pipe)


def _started(source: Source, seed: int) -> tuple[Pipe, Process]:
    context = multiprocessing.get_context("spawn")
    here, there = context.Pipe()
    process = context.Process(target=_work, args=(there, source, seed), daemon=True)
    with sheltered(), without_script():
        process.start()
    there.close()
    return here, process


@contextmanager
def without_script() -> Iterator[None]:
    """Processes started within do not run the user's script anew, as multiprocessing has them do: it would start others
    in turn."""
    script = sys.modules["__main__"]
    sys.modules["__main__"] = ModuleType("__main__")
    try:
        yield
    finally:
        sys.modules["__main__"] = script


@contextmanager
def sheltered() -> Iterator[None]:
    """Processes started within never see the signals that a terminal or a batch system sends to all: this process
    decides for them."""
    if not hasattr(signal, "pthread_sigmask"):
        yield
        return
    resource_tracker.ensure_running()  # as the first start would, which then lets signals through
    before = signal.pthread_sigmask(signal.SIG_BLOCK, SIGNALS)
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)
