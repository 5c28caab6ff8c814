"""Many trials: in this process or in several, with the same numbers whichever way."""

from __future__ import annotations

import multiprocessing
import os
import signal
import time
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from pathlib import Path

from graspdsl.compiler.program import Program, program_of
from graspdsl.diagnostics import Diagnostic, DiagnosticError
from graspdsl.trials.loop import TrialLoop, identity, versions
from graspdsl.trials.record import Trial
from graspdsl.trials.setup import trial_loop
from graspdsl.trials.store import Manifest, RunFolder

OnTrial = Callable[[Trial], None]
TRIALS_WORTH_A_WORKER = 4


class InterruptedRunError(Exception):
    """The user stopped a run; what was finished is kept in ``folder``."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        super().__init__(f"interrupted; finished trials are in {folder}")


def new_run(path: Path, program: Program, text: str, spec_file: str, overrides: Sequence[str]) -> RunFolder:
    """Make the folder of a run that has not begun. Raises DiagnosticError where it cannot be made."""
    trials = program.spec.trials
    manifest = Manifest(program.spec.name, spec_file, tuple(overrides), trials.seed, trials.count, versions())
    return RunFolder.create(path, manifest, text)


def program_of_run(folder: RunFolder) -> Program:
    """The program that a run was made from."""
    return program_of(folder.spec_text, folder.manifest.spec_file, folder.manifest.overrides)


def execute(folder: RunFolder, workers: int | None = None, on_trial: OnTrial | None = None) -> None:
    """Run the trials that are not finished yet; each is committed to the folder as it ends.

    Raises InterruptedRunError when the user stops it and DiagnosticError when the finished trials were made by other
    versions or another spec, so that their numbers would not go together.
    """
    program = program_of_run(folder)
    seed = folder.manifest.seed
    done = {record.number: record.identity for record in folder.records()}
    if any(identity(program, number, seed) != known for number, known in done.items()):
        message = f"{folder.path} was run with another spec or other versions: {_said(folder.manifest.versions)}"
        hint = f"these are {_said(versions())}; begin a new run"
        raise DiagnosticError([Diagnostic("run-differs", message, hint=hint)])
    pending = [number for number in range(folder.manifest.asked) if number not in done]
    if workers is None:
        workers = min(os.cpu_count() or 1, max(1, len(pending) // TRIALS_WORTH_A_WORKER))
    began = time.perf_counter()
    try:
        for trial in _here(program, pending, seed) if workers == 1 else _elsewhere(folder, pending, seed, workers):
            folder.add(trial)
            if on_trial is not None:
                on_trial(trial)
    except KeyboardInterrupt:
        raise InterruptedRunError(folder.path) from None
    finally:
        folder.spend(time.perf_counter() - began)


def _said(of: object) -> str:
    return ", ".join(f"{name} {version}" for name, version in dict(of).items()) if isinstance(of, dict) else str(of)


def _here(program: Program, numbers: Sequence[int], seed: int) -> Iterator[Trial]:
    loop = trial_loop(program)
    for number in numbers:
        yield loop.run(number, seed)


_loop: TrialLoop | None = None  # of a worker process, built once


def _begin_worker(text: str, name: str, overrides: tuple[str, ...]) -> None:
    global _loop
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    _loop = trial_loop(program_of(text, name, overrides))


def _run_in_worker(number: int, seed: int) -> Trial:
    assert _loop is not None
    return _loop.run(number, seed)


def _elsewhere(folder: RunFolder, numbers: Sequence[int], seed: int, workers: int) -> Iterator[Trial]:
    recipe = (folder.spec_text, folder.manifest.spec_file, folder.manifest.overrides)
    context = multiprocessing.get_context("spawn")
    pool = ProcessPoolExecutor(workers, mp_context=context, initializer=_begin_worker, initargs=recipe)
    try:
        waiting: set[Future[Trial]] = {pool.submit(_run_in_worker, number, seed) for number in numbers}
        while waiting:
            finished, waiting = wait(waiting, return_when=FIRST_COMPLETED)
            for future in finished:
                yield future.result()
    finally:
        pool.shutdown(wait=True, cancel_futures=True)
