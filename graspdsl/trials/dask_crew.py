"""A Dask cluster that runs the trials of a run: that of a scheduler, or one of processes on this machine."""

from __future__ import annotations

import importlib
import importlib.util
import itertools
import logging
import math
import os
import pickle
import queue
import time
import uuid
from collections import deque
from collections.abc import Generator, Iterator, Sequence
from contextlib import ExitStack, contextmanager, suppress
from importlib import metadata
from multiprocessing import resource_tracker
from pathlib import Path
from typing import Any

from graspdsl.compiler.program import Program, Source
from graspdsl.diagnostics import Diagnostic, DiagnosticError
from graspdsl.trials.dask_tasks import JOB, Job, Lost, check, entry_of, run_batch
from graspdsl.trials.identity import versions
from graspdsl.trials.loop import OnDrawing
from graspdsl.trials.record import PackedTrial
from graspdsl.trials.sweeps import most_together
from graspdsl.trials.workers import (
    FRUITLESS,
    GLANCE,
    RUNS,
    Drawing,
    OnCrash,
    WorkerEndedError,
    sheltered,
    without_script,
)

AHEAD = 2  # batches that a worker knows of, so that it need not wait for the next
PATIENCE = 10  # s, for a scheduler to answer
EXPECTED = 16  # workers, of a cluster that has none yet and may grow
# Of a cluster for one run: without looks at what workers do, every hundredth of a second, and with fewer at whether all
# still answer. It would give up a worker that is being renewed a while after it was lost, and the last of all, too.
OF_ITS_OWN = {
    "distributed.worker.profile.enabled": False,
    "distributed.admin.tick.interval": "1s",
    "distributed.deploy.lost-worker-timeout": "365 days",
}
LOGGERS = ("distributed", "distributed.client")


class DaskCrew:
    """Who runs the trials of a program on a Dask cluster. ``place``: the scheduler, by its address or the file (.json)
    that it writes it to; or how many processes there are to be on this machine."""

    def __init__(
        self, program: Program, source: Source, seed: int, place: str | int, on_drawing: OnDrawing, on_crash: OnCrash
    ) -> None:
        if importlib.util.find_spec("distributed") is None:
            hint = "pip install 'graspdsl[dask]'; or leave --engine out"
            raise DiagnosticError([Diagnostic("not-installed", "Dask needs distributed", hint=hint)])
        made_by, limit = versions(program), program.spec.trials.wall_limit
        self._job = Job(source, program.files, made_by, program.plugins, seed, limit)
        self._most = most_together(program)
        self._place, self._tell, self._crashed = place, on_drawing, on_crash
        self._run = f"graspdsl-{uuid.uuid4().hex}"
        self._client: Any = None
        self._address = ""
        self._heard = queue.SimpleQueue[Any]()  # futures that are done, and drawings
        self._running: dict[str, tuple[Any, Sequence[int]]] = {}  # futures by their keys, with their trials
        self._left: Iterator[Sequence[int]] = iter(())
        self._again: deque[Sequence[int]] = deque()  # trials whose worker ended
        self._tasks = itertools.count()
        self._workers, self._counted = 0, -GLANCE
        self._fruitless = 0

    def run(self, numbers: Sequence[int]) -> Generator[PackedTrial, None, None]:
        """Run these trials; those of a batch come as it ends.

        Raises DiagnosticError where the scheduler cannot be reached, or is no longer, and where workers have other
        versions; WorkerEndedError where workers end one after the other; and what goes wrong in one without ending it.
        """
        with self._connected():
            self._left = _in_batches(numbers, self._known() or EXPECTED, self._most)
            while self._are_busy():
                try:
                    heard = self._heard.get(timeout=GLANCE)
                except queue.Empty:
                    if self._client.status != "running":
                        raise self._gone() from None
                    continue
                if isinstance(heard, Drawing):
                    self._tell(*heard)
                else:
                    yield from self._done(heard)

    @contextmanager
    def _connected(self) -> Iterator[None]:
        """The client of a cluster whose workers have the same versions."""
        with ExitStack() as stack:
            stack.enter_context(_silenced())
            distributed = importlib.import_module("distributed")
            if isinstance(self._place, str):
                client = self._reached(distributed, self._place)
            else:
                # Processes that it starts later are to be as those that it starts now.
                stack.enter_context(without_script())
                _track_silently()
                stack.enter_context(importlib.import_module("dask.config").set(OF_ITS_OWN))
                with sheltered():
                    cluster = distributed.LocalCluster(
                        n_workers=self._place,
                        threads_per_worker=1,
                        processes=True,
                        memory_limit=None,
                        dashboard_address=":0",
                        silence_logs=logging.CRITICAL,
                    )
                stack.enter_context(cluster)
                client = distributed.Client(cluster, set_as_default=False)
            self._client, self._address = stack.enter_context(client), client.scheduler.address
            self._check_versions()
            client.set_metadata([self._run], {JOB: pickle.dumps(self._job)})
            client.subscribe_topic(self._run, lambda event: self._heard.put(Drawing(*event[1])))
            stack.callback(self._leave)
            yield

    def _reached(self, distributed: Any, scheduler: str) -> Any:
        by_file = scheduler.endswith(".json")
        try:
            if by_file and not Path(scheduler).is_file():
                raise OSError("there is no such file")
            where = {"scheduler_file": scheduler} if by_file else {"address": scheduler}
            return distributed.Client(**where, timeout=PATIENCE, set_as_default=False)
        except (OSError, ValueError) as error:
            raise self._unreached(f"the Dask scheduler {scheduler} cannot be reached: {error}") from error

    def _gone(self) -> DiagnosticError:
        """The complaint about a scheduler that has gone away."""
        return self._unreached(f"the Dask scheduler {self._address} has gone away")

    @contextmanager
    def _asking(self) -> Iterator[None]:
        """Within, the scheduler is asked for something."""
        try:
            yield
        except (OSError, importlib.import_module("distributed").CancelledError) as error:
            raise self._gone() from error

    def _unreached(self, message: str) -> DiagnosticError:
        return DiagnosticError([Diagnostic("no-scheduler", message)])

    def _leave(self) -> None:
        """Nobody waits for what is still running, nor asks for the run."""
        if self._client.status != "running":
            return
        with suppress(OSError):  # of a scheduler that goes away now
            self._client.unsubscribe_topic(self._run)
            self._client.cancel([future for future, _ in self._running.values()], force=True)
            self._client.set_metadata([self._run], None)

    def _check_versions(self) -> None:
        """Whether the workers that there are, and the scheduler, have what is here; by means that all of them have."""
        wanted, found = self._job.made_by, dict[str, dict[str, str]]()
        with self._asking():
            try:
                own = self._client.run_on_scheduler(metadata.version, "graspdsl")
            except metadata.PackageNotFoundError:
                own = ""
            found["the Dask scheduler"] = {"graspdsl": own}
            for name in wanted:
                there = self._client.run(metadata.version, name, on_error="return")
                for address, version in there.items():
                    of_worker = found.setdefault(f"the Dask worker {address}", {})
                    of_worker[name] = version if isinstance(version, str) else ""
        check(found, wanted)

    def _known(self) -> int:
        """How many workers the cluster has now, looked up now and then."""
        if time.monotonic() - self._counted > GLANCE:
            with self._asking():
                self._workers, self._counted = len(self._client.nthreads()), time.monotonic()
        return self._workers

    def _are_busy(self) -> bool:
        """Whether any trials are at work, once all workers have been given some."""
        most = AHEAD * (self._known() or EXPECTED)
        while len(self._running) < most and (numbers := self._next()):
            key = f"{self._run}-{next(self._tasks)}"
            future = self._client.submit(run_batch, self._run, tuple(numbers), key=key, pure=False)
            self._running[key] = future, numbers
            future.add_done_callback(self._heard.put)
        return bool(self._running)

    def _next(self) -> Sequence[int] | None:
        return self._again.popleft() if self._again else next(self._left, None)

    def _done(self, future: Any) -> Iterator[PackedTrial]:
        _, numbers = self._running.pop(future.key)
        if future.status == "error":
            found: list[PackedTrial] | Lost = self._failed(future.exception(), numbers)
        else:
            with self._asking():
                found = future.result()
        if not isinstance(found, Lost):
            self._fruitless = 0
            yield from found
            return
        self._fruitless += 1
        if self._fruitless == FRUITLESS:
            raise WorkerEndedError(found.ends[-1] if found.ends else "before any trial began", None)
        if len(numbers) > 1 and found.ends:
            self._again.extend([number] for number in numbers)
        elif len(found.ends) < RUNS:
            self._again.append(numbers)
        else:
            yield self._crashed(numbers[0], found.ends[-1])

    def _failed(self, error: BaseException, numbers: Sequence[int]) -> Lost:
        """What is known of trials whose workers ended too often for Dask; raises any other error."""
        if isinstance(error, importlib.import_module("distributed").KilledWorker):
            with self._asking():
                return Lost(tuple(self._client.get_metadata(entry_of(self._run, numbers), [])))
        raise error


def _in_batches(numbers: Sequence[int], workers: int, most: int) -> Iterator[Sequence[int]]:
    """The numbers in parts of nearly equal length, at most so long, of which each of the workers gets as many."""
    workers = min(workers, len(numbers))
    rounds = math.ceil(len(numbers) / (workers * most))
    size = math.ceil(len(numbers) / (workers * rounds))
    return (numbers[first : first + size] for first in range(0, len(numbers), size))


def _track_silently() -> None:
    """Begin Python's tracker of semaphores as one that does not complain of those that a signal leaves to it."""
    told = os.environ.get("PYTHONWARNINGS", "")
    os.environ["PYTHONWARNINGS"] = ",".join(filter(None, (told, "ignore:resource_tracker")))
    resource_tracker.ensure_running()
    os.environ["PYTHONWARNINGS"] = told  # of which an empty one is none


@contextmanager
def _silenced() -> Iterator[None]:
    """Within, Dask says nothing on stderr: of workers that end and schedulers that go away the run tells by itself."""
    loggers = [logging.getLogger(name) for name in LOGGERS]
    importlib.import_module("distributed")  # which sets their levels
    before = [logger.level for logger in loggers]
    for logger in loggers:
        logger.setLevel(logging.CRITICAL + 1)
    try:
        yield
    finally:
        for logger, level in zip(loggers, before, strict=True):
            logger.setLevel(level)
