"""What a process of a Dask cluster does with the trials that it is given: a batch of them is a task.

Dask runs a task again whose process is lost, and does not say so. So each beginning of a task is noted at the
scheduler before its trials begin; who begins a task sees there whether the process before it came to an end.
"""

from __future__ import annotations

import importlib
import os
import pickle
import threading
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from importlib import metadata
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, NamedTuple

from graspdsl.compiler.program import Program, Source, program_of
from graspdsl.diagnostics import Diagnostic, DiagnosticError, listed
from graspdsl.places.files import NamedFile
from graspdsl.plugins.answering import answered_for
from graspdsl.plugins.kinds import Plugin
from graspdsl.trials.identity import other_plugins
from graspdsl.trials.loop import TrialLoop
from graspdsl.trials.record import PackedTrial
from graspdsl.trials.sweeps import SweepLoop, loop_over
from graspdsl.trials.workers import GLANCE, RUNS, too_long

JOB = "job"  # what a run's entry at the scheduler has it under


class Job(NamedTuple):
    """What a run's trials are made from, files and all, for the processes see none of ours. ``made_by``: the versions
    that they must have; ``limit`` [s]: of wall time that a trial may take by itself."""

    source: Source
    files: tuple[NamedFile, ...]
    made_by: Mapping[str, str]
    plugins: tuple[Plugin, ...]
    seed: int
    limit: float


class Lost(NamedTuple):
    """Trials of which no more is known than what ended the processes that were at them."""

    ends: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class _Kept:
    """What a process keeps from one batch of a run to the next: one simulator, and the folder of the spec's files."""

    run: str
    job: Job
    program: Program
    loop: TrialLoop | SweepLoop
    folder: TemporaryDirectory[str]


_kept: list[_Kept] = []  # that of the last run
_alone = threading.Lock()  # a worker may have several threads, of which one at a time may have the simulator


def entry_of(run: str, numbers: Sequence[int]) -> list[str]:
    """Where the beginnings of a batch are noted at the scheduler."""
    return [run, f"{numbers[0]}" if len(numbers) == 1 else f"{numbers[0]} …"]


def run_batch(run: str, numbers: Sequence[int]) -> list[PackedTrial] | Lost:
    """The trials of these numbers, side by side; those whose processes ended as often as they may are lost. One that is
    beside others may end it once: which of them did, nobody knows.

    Raises DiagnosticError where other versions, or other plug-ins, are here than where the run is.
    """
    distributed = importlib.import_module("distributed")
    worker, scheduler, entry = distributed.get_worker(), distributed.get_client(), entry_of(run, numbers)
    with _alone:
        ends = scheduler.get_metadata(entry, [])
        if len(ends) >= (RUNS if len(numbers) == 1 else 1):
            return Lost(tuple(ends))
        kept = _kept_for(run, scheduler, worker.address)
        limit, keep = kept.job.limit, kept.program.spec.trials.keep

        def late() -> None:
            scheduler.set_metadata(entry, [*ends, too_long(limit)])
            os._exit(1)

        def tell(number: int, draws: int) -> None:
            watch.heard = time.monotonic()
            worker.log_event(run, [number, draws])

        scheduler.set_metadata(entry, [*ends, f"the Dask worker {worker.address} is lost"])
        trials = list[PackedTrial]()
        with _watching(kept.loop, limit, late) as watch, answered_for(kept.program.plugins):
            for trial in kept.loop.run_all(numbers, kept.job.seed, tell):
                trials.append(trial.packed(keep))
                watch.heard = time.monotonic()
        return trials


@dataclass(slots=True)
class _Watch:
    """When the trials at work were last heard of [s]."""

    heard: float


@contextmanager
def _watching(loop: TrialLoop | SweepLoop, limit: float, late: Callable[[], object]) -> Iterator[_Watch]:
    """Within, trials that nothing is heard of for longer than all of them may take, [s] each, are late."""
    watch, done = _Watch(time.monotonic()), threading.Event()

    def look() -> None:
        while not done.wait(GLANCE):
            if time.monotonic() - watch.heard > limit * max(loop.running, 1):
                late()

    threading.Thread(target=look, daemon=True).start()
    try:
        yield watch
    finally:
        done.set()


def _kept_for(run: str, scheduler: Any, address: str) -> _Kept:
    if not _kept or _kept[0].run != run:
        _kept.clear()
        _kept.append(_made(run, pickle.loads(scheduler.get_metadata([run, JOB])), address))
    return _kept[0]


def _made(run: str, job: Job, address: str) -> _Kept:
    check({f"the Dask worker {address}": {name: _version(name) for name in job.made_by}}, job.made_by)
    folder = TemporaryDirectory(prefix="graspdsl-")
    for file in job.files:
        file.copy_into(Path(folder.name))
    try:
        program = program_of(*job.source._replace(folder=Path(folder.name)))
    except DiagnosticError as error:
        message = f"the Dask worker {address} refuses this spec: {error.diagnostics[0].message}"
        raise _differs(message, "install there what is installed here") from error
    if program.plugins != job.plugins:
        here, there = other_plugins(job.plugins, program.plugins)
        message = f"the Dask worker {address} has {listed(there)}; here there is {listed(here)}"
        raise _differs(message, "install the same there")
    with answered_for(program.plugins):
        return _Kept(run, job, program, loop_over(program), folder)


def check(found: Mapping[str, Mapping[str, str]], wanted: Mapping[str, str]) -> None:
    """Raises DiagnosticError about the first process that has other versions than are wanted, or lacks one; found:
    versions by who has them and by names, empty for what is not installed."""
    for who, versions in found.items():
        others = {name: version for name, version in versions.items() if version != wanted[name]}
        if others:
            has = listed(f"{name} {version}" if version else f"no {name}" for name, version in others.items())
            message = f"{who} has {has}; here there is "
            message += listed(f"{name} {wanted[name]}" for name in others)
            raise _differs(message, f"install there: {' '.join(f'{name}=={wanted[name]}' for name in others)}")


def _version(name: str) -> str:
    with suppress(metadata.PackageNotFoundError):
        return metadata.version(name)
    return ""


def _differs(message: str, hint: str) -> DiagnosticError:
    return DiagnosticError([Diagnostic("workers-differ", message, hint=hint)])
