"""Many trials: in this process or in several, with the same numbers whichever way."""

from __future__ import annotations

import functools
import multiprocessing
import multiprocessing.process
import os
import signal
import threading
import time
from collections.abc import Callable, Generator, Iterator, Mapping, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from contextlib import closing, contextmanager
from pathlib import Path

from graspdsl.compiler.program import Program, program_of
from graspdsl.diagnostics import Diagnostic, DiagnosticError, listed
from graspdsl.trials.identity import FILE_READERS, identities, other_origin, versions
from graspdsl.trials.loop import TrialLoop
from graspdsl.trials.record import Trial, TrialRecord
from graspdsl.trials.setup import trial_loop
from graspdsl.trials.store import Manifest, RunFolder

OnTrial = Callable[[Trial], None]
TRIALS_WORTH_A_WORKER = 4
_STOPPED = {getattr(signal, name, None) for name in ("SIGKILL", "SIGTERM", "SIGINT", "SIGHUP")}


class WorkerEndedError(Exception):
    """A worker process ended before its trial did; ``from_outside`` when somebody or the system stopped it."""

    def __init__(self, exit_code: int | None) -> None:
        self.from_outside = exit_code is not None and -exit_code in _STOPPED
        cause = "" if exit_code is None else f" ({_said_exit(exit_code)})"
        advice = "; if memory is short, fewer --workers need less" if exit_code == -signal.SIGKILL else ""
        super().__init__(f"a worker process ended too early{cause}{advice}")


def new_run(path: Path, program: Program, text: str, spec_file: str, overrides: Sequence[str]) -> RunFolder:
    """Make the folder of a run that has not begun. Raises DiagnosticError where it cannot be made."""
    trials = program.spec.trials
    manifest = Manifest(
        program.spec.name, spec_file, tuple(overrides), trials.seed, trials.count, versions(readers=bool(program.files))
    )
    return RunFolder.create(path, manifest, text, program.files)


def program_of_run(folder: RunFolder) -> Program:
    """The program that a run was made from."""
    return program_of(*_recipe(folder))


def pending(folder: RunFolder, program: Program, finished: Sequence[TrialRecord]) -> list[int]:
    """The numbers of the trials of a run's program that are not among its finished ones.

    Raises DiagnosticError when the finished ones were made by other versions or another spec, so that their numbers
    and new ones would not go together.
    """
    done = {record.number: record.identity for record in finished}
    identity_of = identities(program, folder.manifest.seed, versions(readers=bool(program.files)))
    if any(identity_of(number) != known for number, known in done.items()):
        raise DiagnosticError([_differs(folder.manifest.versions)])
    return [number for number in range(folder.manifest.asked) if number not in done]


def execute(
    folder: RunFolder,
    workers: int | None = None,
    on_trial: OnTrial | None = None,
    finished: Sequence[TrialRecord] | None = None,
) -> None:
    """Run the trials that are not finished yet; each is committed to the folder as it ends.

    finished: those that are, where they have been read already, for that takes a look at every trajectory.

    Raises DiagnosticError as ``pending`` does, or when the folder cannot be written to; WorkerEndedError when a worker
    is killed. After these, as after KeyboardInterrupt, what was finished is kept and another call goes on.
    """
    program = program_of_run(folder)
    numbers = pending(folder, program, folder.finished() if finished is None else finished)
    if not numbers:
        return
    if workers is None:
        workers = min(os.cpu_count() or 1, max(1, len(numbers) // TRIALS_WORTH_A_WORKER))
    workers = min(workers, len(numbers))
    began, seed = time.perf_counter(), folder.manifest.seed
    trials = _here(program, numbers, seed) if workers == 1 else _elsewhere(folder, numbers, seed, workers)
    try:
        with closing(trials):
            for trial in trials:
                folder.add(trial)
                if on_trial is not None:
                    on_trial(trial)
    finally:
        folder.spend(time.perf_counter() - began)


def _differs(made_by: Mapping[str, str]) -> Diagnostic:
    here = versions(readers=not made_by.keys().isdisjoint(FILE_READERS))
    changed = {name: version for name, version in here.items() if made_by.get(name) != version}
    if not changed:
        return other_origin()
    before = listed(f"{name} {made_by.get(name, 'of no known version')}" for name in changed)
    now = listed(f"{name} {version}" for name, version in changed.items())
    return Diagnostic("run-differs", f"this run was made with {before}; now there is {now}", hint="begin a new run")


def _here(program: Program, numbers: Sequence[int], seed: int) -> Generator[Trial, None, None]:
    loop = trial_loop(program)
    for number in numbers:
        yield loop.run(number, seed)


Recipe = tuple[str, str, tuple[str, ...], Path]  # what program_of makes a program from


def _recipe(folder: RunFolder) -> Recipe:
    return folder.spec_text, folder.manifest.spec_file, folder.manifest.overrides, folder.files


@functools.cache  # built once in a worker process, at its first trial, so that what goes wrong there is reported
def _loop(recipe: Recipe) -> TrialLoop:
    return trial_loop(program_of(*recipe))


def _run_in_worker(recipe: Recipe, number: int, seed: int) -> Trial:
    return _loop(recipe).run(number, seed)


def _begin_worker() -> None:
    threading.Thread(target=_end_with_parent, daemon=True).start()


def _end_with_parent() -> None:
    """A worker waits for work for ever; should its parent be killed, nobody else would end it."""
    parent = multiprocessing.parent_process()
    if parent is not None:
        parent.join()
        os._exit(1)


def _elsewhere(folder: RunFolder, numbers: Sequence[int], seed: int, workers: int) -> Generator[Trial, None, None]:
    recipe = _recipe(folder)
    others = set(multiprocessing.active_children())
    context = multiprocessing.get_context("spawn")
    pool = ProcessPoolExecutor(workers, mp_context=context, initializer=_begin_worker)
    processes: list[multiprocessing.process.BaseProcess] = []
    waiting: set[Future[Trial]] = set()
    try:
        with _sheltered():
            waiting = {pool.submit(_run_in_worker, recipe, number, seed) for number in numbers}
            processes = [child for child in multiprocessing.active_children() if child not in others]
        while waiting:
            finished, waiting = wait(waiting, return_when=FIRST_COMPLETED)
            for future in finished:
                yield future.result()
    except BrokenProcessPool:
        pool.shutdown(wait=True)  # its own thread waits for the processes; only then are all exit codes known
        raise WorkerEndedError(_first_cause(processes)) from None
    finally:
        if waiting:  # not to the end: nobody waits for the trials that are still running
            for process in processes:
                process.kill()
        pool.shutdown(wait=True, cancel_futures=True)


@contextmanager
def _sheltered() -> Iterator[None]:
    """Processes started within never see Ctrl-C, which a terminal sends to all: this process decides for them."""
    if not hasattr(signal, "pthread_sigmask"):
        yield
        return
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


def _first_cause(processes: Sequence[multiprocessing.process.BaseProcess]) -> int | None:
    """The exit code of the worker that broke the pool; the pool then ends the others by SIGTERM."""
    codes = [process.exitcode for process in processes if process.exitcode is not None]
    return next((code for code in codes if code != -signal.SIGTERM), codes[0] if codes else None)


def _said_exit(exit_code: int) -> str:
    return f"exit code {exit_code}" if exit_code >= 0 else signal.Signals(-exit_code).name
