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
from graspdsl.trials.setup import trial_loop

ENGINES = ("local", "dask")
AHEAD = 2  # batches that a worker knows of, so that it need not wait for the next
GLANCE = 0.5  # s
RUNS = 2  # of a trial that kills its worker
FRUITLESS = 10  # workers that may die one after the other before any trial is finished
GROWN, SPARE = 2.0, 256e6  # a worker that needs more than so many times, and bytes, of its first batch is replaced
_STOPPED = {getattr(signal, name, None) for name in ("SIGKILL", "SIGTERM", "SIGINT", "SIGHUP")}

OnCrash = Callable[[int, str], PackedTrial]  # what is kept of a trial, by its number, and of what ended its process


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


def in_batches(numbers: Sequence[int], workers: int, most: int) -> Iterator[Sequence[int]]:
    """The numbers in parts of nearly equal length, at most so long, of which each of the workers gets as many."""
    workers = min(workers, len(numbers))
    rounds = math.ceil(len(numbers) / (workers * most))
    size = math.ceil(len(numbers) / (workers * rounds))
    return (numbers[first : first + size] for first in range(0, len(numbers), size))


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
    """A process has made its world; or its batch is done, and ``retires`` tells whether it ends with that."""

    retires: bool


Message = Finished | Drawing | Ready
Process = multiprocessing.process.BaseProcess
Pipe = multiprocessing.connection.Connection  # batches of trials to a worker; to here messages, or an exception


def _work(pipe: Pipe, source: Source, seed: int) -> None:
    """What a worker process does, until it is killed or needs much more memory than it did."""
    threading.Thread(target=_end_with_parent, daemon=True).start()
    try:
        program = program_of(*source)
        with answered_for(program.plugins):
            loop, keep = trial_loop(program), program.spec.trials.keep
            pipe.send(Ready(retires=False))
            enough, retires = 0.0, False
            while not retires:
                for trial in loop.run_all(pipe.recv(), seed, functools.partial(_tell, pipe)):
                    pipe.send(Finished(trial.packed(keep), _memory()))
                enough = enough or GROWN * _memory() + SPARE
                retires = _memory() > enough
                pipe.send(Ready(retires))
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
    """A process, and the numbers of the trials that were given to it and that it has not finished, by batches.

    ``heard``: when it last said something [s]; ``memory`` [bytes]: the most that it has told of; ``is_late``: whether
    it was killed since it said nothing for too long.
    """

    process: Process
    batches: deque[list[int]] = field(default_factory=deque)
    is_ready: bool = False
    heard: float = field(default_factory=time.monotonic)
    memory: float = 0.0
    is_late: bool = False


class Crew:
    """So many workers, to run the trials of a run. ``limit`` [s]: of wall time that a trial may take by itself."""

    def __init__(
        self, source: Source, seed: int, workers: int, limit: float, on_drawing: OnDrawing, on_crash: OnCrash
    ) -> None:
        self._source, self._seed, self._count, self._limit = source, seed, workers, limit
        self._tell, self._crashed = on_drawing, on_crash
        self._workers: dict[Pipe, _Worker] = {}
        self._left: Iterator[list[int]] = iter(())
        self._suspects: deque[int] = deque()  # trials whose worker ended
        self._ends: Counter[int] = Counter()  # of workers, by the trials that they were at
        self._fruitless = 0

    def run(self, numbers: Sequence[int], most: int) -> Generator[PackedTrial, None, None]:
        """Run these trials, at most so many side by side; each comes as it ends.

        Raises WorkerEndedError where workers die one after the other, and what goes wrong in one without ending it.
        """
        self._left = map(list, in_batches(numbers, self._count, most))
        with interruption.at_the_end(self._kill):
            while self._are_busy():
                # A signal just before a wait is heeded after it.
                heard = multiprocessing.connection.wait(list(self._workers), timeout=GLANCE)
                for pipe in set(self._workers).intersection(heard):
                    yield from self._heard(pipe)
                self._kill_late()

    def _are_busy(self) -> bool:
        """Whether any worker has trials, once all have been given some."""
        while len(self._workers) < self._count and (batch := self._next()):
            with interruption.whole():
                pipe, process = _started(self._source, self._seed)
                self._workers[pipe] = _Worker(process)
            self._give(pipe, batch)
        for ahead in range(AHEAD):
            for pipe, worker in self._workers.items():
                if len(worker.batches) == ahead and (batch := self._next(alone=not ahead)):
                    self._give(pipe, batch)
        return any(worker.batches for worker in self._workers.values())

    def _next(self, *, alone: bool = True) -> list[int] | None:
        """The next batch; ``alone``: it may be a suspect, which no other trial is to be suspected with."""
        return [self._suspects.popleft()] if alone and self._suspects else next(self._left, None)

    def _give(self, pipe: Pipe, batch: list[int]) -> None:
        self._workers[pipe].batches.append(batch)
        with suppress(OSError):  # that it has ended is found when its trials are awaited
            pipe.send(batch)

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
                worker.batches[0].remove(trial.record.number)
                yield trial
            case Ready(retires):
                if worker.is_ready:
                    worker.batches.popleft()
                worker.is_ready = True
                if retires:
                    self._left = itertools.chain(self._buried(pipe).batches, self._left)

    def _ended(self, pipe: Pipe) -> Iterator[PackedTrial]:
        """What becomes of the trials of a worker that has ended."""
        worker = self._buried(pipe)
        running = worker.batches.popleft() if worker.is_ready and worker.batches else []
        self._left = itertools.chain(worker.batches, self._left)
        self._fruitless += 1
        if self._fruitless == FRUITLESS:
            raise WorkerEndedError(self._cause(worker), worker.process.exitcode)
        for number in running:
            self._ends[number] += 1
            if self._ends[number] < RUNS:
                self._suspects.append(number)
            else:
                yield self._crashed(number, f"its process ended, {RUNS} times: {self._cause(worker)}")

    def _buried(self, pipe: Pipe) -> _Worker:
        worker = self._workers.pop(pipe)
        worker.process.join(timeout=GLANCE)
        pipe.close()
        return worker

    def _cause(self, worker: _Worker) -> str:
        """What is known of how a worker ended."""
        if worker.is_late:
            return f"after more than {self._limit:g} s, trials.wall_limit"
        code = worker.process.exitcode
        said = "no exit code" if code is None else f"exit code {code}" if code >= 0 else signal.Signals(-code).name
        return f"{said}, with {worker.memory / 1e6:.0f} MB" if worker.memory else said

    def _kill_late(self) -> None:
        """Kill workers that have said nothing for longer than all trials that they are at may take."""
        now = time.monotonic()
        for worker in self._workers.values():
            running = len(worker.batches[0]) if worker.is_ready and worker.batches else 0
            if running and now - worker.heard > self._limit * running:
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
