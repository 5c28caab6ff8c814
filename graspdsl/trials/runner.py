"""Many trials: in this process or in several, with the same numbers whichever way."""

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
from collections import Counter
from collections.abc import Callable, Generator, Iterator, Mapping, Sequence
from contextlib import closing, contextmanager, suppress
from multiprocessing import resource_tracker
from pathlib import Path
from types import ModuleType

from graspdsl.compiler.program import Program, Source, lacking, program_of
from graspdsl.diagnostics import Diagnostic, DiagnosticError, listed
from graspdsl.objects.shapes import Body
from graspdsl.objects.standing import pose_at_rest
from graspdsl.plugins.answering import answered_for
from graspdsl.trials.identity import identities, other_origin, other_plugins, versions
from graspdsl.trials.interruption import SIGNALS, interruption
from graspdsl.trials.loop import OnDrawing, TrialLoop, together
from graspdsl.trials.outcomes import Outcome
from graspdsl.trials.record import Trial, TrialRecord
from graspdsl.trials.setup import trial_loop
from graspdsl.trials.store import Manifest, RunFolder

OnTrial = Callable[[Trial], object]
TRIALS_TO_BEGIN = 10  # of which one must, or none of a run is likely to
AHEAD = 8  # trials that a worker knows of besides those it runs, so that it need not wait for the next
GLANCE = 0.5  # s
_STOPPED = {getattr(signal, name, None) for name in ("SIGKILL", "SIGTERM", "SIGINT", "SIGHUP")}


class WorkerEndedError(Exception):
    """A worker process ended before its trial did; ``from_outside`` when somebody or the system stopped it."""

    def __init__(self, exit_code: int | None) -> None:
        self.from_outside = exit_code is not None and -exit_code in _STOPPED
        cause = "" if exit_code is None else f" ({_said_exit(exit_code)})"
        advice = "; if memory is short, fewer --workers need less" if exit_code == -signal.SIGKILL else ""
        super().__init__(f"a worker process ended too early{cause}{advice}")


def new_run(path: Path, program: Program) -> RunFolder:
    """Make the folder of a run that has not begun. Raises DiagnosticError where it cannot be made, or its world."""
    _can_be_run(program)
    source, trials, made_by = program.source, program.spec.trials, versions(program)
    manifest = Manifest(
        *(program.spec.name, source.name, source.overrides, trials.seed, trials.count, made_by),
        plugins=program.plugins,
    )
    return RunFolder.create(path, manifest, source.text, program.files, allow_code=source.allow_code)


def source_of(folder: RunFolder) -> Source:
    """What a run's program is read from."""
    manifest = folder.manifest
    return Source(folder.spec_text, manifest.spec_file, manifest.overrides, folder.files, folder.allow_code)


def program_of_run(folder: RunFolder) -> Program:
    """The program that a run was made from."""
    return program_of(*source_of(folder))


def pending(folder: RunFolder, program: Program, finished: Sequence[TrialRecord]) -> list[int]:
    """The numbers of the trials of a run's program that are not among its finished ones.

    Raises DiagnosticError when the finished ones were made by other versions or another spec, so that their numbers
    and new ones would not go together.
    """
    done = {record.number: record.identity for record in finished}
    identity_of = identities(program, folder.manifest.seed)
    if any(identity_of(number) != known for number, known in done.items()):
        raise DiagnosticError([_differs(folder.manifest, program)])
    return [number for number in range(folder.manifest.asked) if number not in done]


def execute(
    folder: RunFolder,
    workers: int | None = None,
    on_trial: OnTrial | None = None,
    finished: Sequence[TrialRecord] | None = None,
    on_drawing: OnDrawing | None = None,
) -> None:
    """Run the trials that are not finished yet; each is committed to the folder as it ends.

    finished: those that are, where they have been read already, for that takes a look at every trajectory.

    Raises DiagnosticError as ``pending`` does, when the folder cannot be written to, or when none of the first trials
    could begin (on a grid, where each trial starts elsewhere, all may run); WorkerEndedError when a worker is killed.
    After these, as after KeyboardInterrupt, what was finished is kept and another call goes on.
    """
    with folder.held():
        if finished is None:
            finished = folder.finished()
        program = program_of_run(folder)
        numbers = pending(folder, program, finished)
        if not numbers:
            return
        _can_be_run(program)
        if workers is None:
            workers = min(os.cpu_count() or 1, max(1, len(numbers) // program.world.worth_a_worker))
        workers = min(workers, len(numbers))
        share = min(math.ceil(len(numbers) / workers), together(program) + AHEAD)
        began, seed = time.perf_counter(), folder.manifest.seed

        def spend() -> None:
            with suppress(DiagnosticError):  # how long it took is not worth hiding how it ended
                folder.spend(time.perf_counter() - began)

        tell = on_drawing or (lambda _number, _draws: None)
        if workers == 1:
            trials = _here(program, numbers, seed, tell)
        else:
            trials = _elsewhere(folder, numbers, share, seed, workers, tell)
        first = min(TRIALS_TO_BEGIN, folder.manifest.asked)
        barren = {record.number: record for record in finished if record.number < first and not record.has_begun}
        with interruption.at_the_end(spend), closing(trials):
            for trial in trials:
                folder.add(trial)
                if on_trial is not None:
                    on_trial(trial)
                if trial.record.number < first and not trial.record.has_begun:
                    barren[trial.record.number] = trial.record
                if len(barren) == first and program.spec.trials.grid is None:
                    raise DiagnosticError([_none_begins(list(barren.values()), program.body)])


def _can_be_run(program: Program) -> None:
    if missing := lacking(program):
        raise DiagnosticError([missing[0]])


def _none_begins(records: Sequence[TrialRecord], body: Body) -> Diagnostic:
    reasons = Counter(start.reason for record in records for start in record.rejected)
    reasons.update(record.detail for record in records if not record.rejected)
    trials = (
        "the trial could not begin" if len(records) == 1 else f"none of the first {len(records)} trials could begin"
    )
    found = "; ".join(f"{reason} ({count})" for reason, count in reasons.most_common())
    message = f"{trials}: {found}"
    hint = "let trials.start put the hand elsewhere, or use another object"
    if {record.outcome for record in records} == {Outcome.TOPPLED}:
        hint = f"add '{pose_at_rest(body.shape) or 'fixed: true'}' to the object, or use another one"
    return Diagnostic("no-trial-begins", message, hint=hint)


def _differs(manifest: Manifest, program: Program) -> Diagnostic:
    made_by, here = manifest.versions, versions(program)
    changed = {name: version for name, version in here.items() if made_by.get(name) != version}
    before = [f"{name} {made_by.get(name, 'of no known version')}" for name in changed]
    now = [f"{name} {version}" for name, version in changed.items()]
    of_plugins = other_plugins(manifest.plugins, program.plugins)
    made, found = (listed([*own, *others]) for own, others in zip((before, now), of_plugins, strict=True))
    if not found:
        return other_origin()
    return Diagnostic("run-differs", f"this run was made with {made}; now there is {found}", hint="begin a new run")


Worker = multiprocessing.process.BaseProcess
Pipe = multiprocessing.connection.Connection  # numbers of trials to a worker; to here what comes of them
Answer = Trial | tuple[int, int]  # or, as of OnDrawing, that one looks for a start


def _work(pipe: Pipe, source: Source, seed: int) -> None:
    """What a worker process does, until it is killed."""
    threading.Thread(target=_end_with_parent, daemon=True).start()
    try:
        program = program_of(*source)
        with answered_for(program.plugins):
            loop = trial_loop(program)
            for trial in loop.run_all(_asked_for(pipe, loop), seed, functools.partial(_tell, pipe)):
                pipe.send(trial)
    except Exception as error:
        error.add_note("".join(traceback.format_exception(error)))  # where it was, which does not travel by itself
        with suppress(OSError):  # nobody is there any more
            pipe.send(error)


def _asked_for(pipe: Pipe, loop: TrialLoop) -> Iterator[int | None]:
    """The numbers of trials for a loop, without end; None where there is none now, and others run meanwhile."""
    while True:
        if loop.running and not pipe.poll():
            yield None
        else:
            yield from pipe.recv()


def _tell(pipe: Pipe, number: int, draws: int) -> None:
    pipe.send((number, draws))


def _end_with_parent() -> None:
    """Should the parent of a worker be killed in the middle of a trial, nobody else would end it."""
    parent = multiprocessing.parent_process()
    if parent is not None:
        parent.join()
        os._exit(1)


def _here(program: Program, numbers: Sequence[int], seed: int, tell: OnDrawing) -> Generator[Trial, None, None]:
    with answered_for(program.plugins):
        yield from trial_loop(program).run_all(numbers, seed, tell)


def _elsewhere(
    folder: RunFolder, numbers: Sequence[int], share: int, seed: int, workers: int, tell: OnDrawing
) -> Generator[Trial, None, None]:
    """share: how many trials a worker knows of."""
    source, left = source_of(folder), iter(numbers)
    crew: dict[Pipe, Worker] = {}
    waiting = len(numbers)

    def give(pipe: Pipe, count: int) -> None:
        if more := list(itertools.islice(left, count)):
            with suppress(OSError):  # that it has ended is found when its trials are awaited
                pipe.send(more)

    with interruption.at_the_end(lambda: _kill(crew)):
        for _ in range(workers):
            with interruption.whole():
                pipe, worker = _started(source, seed)
                crew[pipe] = worker
        for pipe in crew:
            give(pipe, share)
        while waiting:
            # A signal just before a wait is heeded after it.
            for pipe in set(crew).intersection(multiprocessing.connection.wait(list(crew), timeout=GLANCE)):
                answer = _received(pipe, crew[pipe])
                if isinstance(answer, tuple):
                    tell(*answer)
                else:
                    give(pipe, 1)
                    waiting -= 1
                    yield answer


def _started(source: Source, seed: int) -> tuple[Pipe, Worker]:
    context = multiprocessing.get_context("spawn")
    here, there = context.Pipe()
    worker = context.Process(target=_work, args=(there, source, seed), daemon=True)
    with _sheltered(), _without_script():
        worker.start()
    there.close()
    return here, worker


@contextmanager
def _without_script() -> Iterator[None]:
    """Processes started within do not run the user's script anew, as multiprocessing has them do: it would start others
    in turn."""
    script = sys.modules["__main__"]
    sys.modules["__main__"] = ModuleType("__main__")
    try:
        yield
    finally:
        sys.modules["__main__"] = script


def _received(pipe: Pipe, worker: Worker) -> Answer:
    try:
        answer: Answer | Exception = pipe.recv()
    except (EOFError, OSError):
        worker.join(timeout=GLANCE)
        raise WorkerEndedError(worker.exitcode) from None
    if isinstance(answer, Exception):
        raise answer
    return answer


def _kill(crew: Mapping[Pipe, Worker]) -> None:
    """Nobody waits for the trials that are still running."""
    for worker in crew.values():
        worker.kill()
    for pipe, worker in crew.items():
        worker.join(timeout=GLANCE)
        pipe.close()


@contextmanager
def _sheltered() -> Iterator[None]:
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


def _said_exit(exit_code: int) -> str:
    return f"exit code {exit_code}" if exit_code >= 0 else signal.Signals(-exit_code).name
