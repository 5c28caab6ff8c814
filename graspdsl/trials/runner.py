"""Many trials: in this process or in several, with the same numbers whichever way."""

from __future__ import annotations

import os
import time
from collections import Counter
from collections.abc import Callable, Generator, Sequence
from contextlib import closing, suppress
from pathlib import Path

from graspdsl.compiler.program import Program, Source, lacking, program_of
from graspdsl.diagnostics import Diagnostic, DiagnosticError, listed
from graspdsl.objects.shapes import Body
from graspdsl.objects.standing import pose_at_rest
from graspdsl.plugins.answering import answered_for
from graspdsl.trials.crashed import crashed
from graspdsl.trials.identity import at_one_point, identities, other_origin, other_plugins, versions
from graspdsl.trials.interruption import interruption
from graspdsl.trials.loop import OnDrawing
from graspdsl.trials.outcomes import Outcome
from graspdsl.trials.record import PackedTrial, TrialRecord
from graspdsl.trials.store import Manifest, RunFolder
from graspdsl.trials.sweeps import loop_over, most_together
from graspdsl.trials.workers import RUNS, Crew, Dask, Workers

OnRecord = Callable[[TrialRecord], object]
TRIALS_TO_BEGIN = 10  # of which one must, or none of a run is likely to


def new_run(path: Path, program: Program) -> RunFolder:
    """Make the folder of a run that has not begun. Raises DiagnosticError where it cannot be made, or its world."""
    _can_be_run(program)
    source, trials, made_by = program.source, program.spec.trials, versions(program)
    manifest = Manifest(
        *(program.spec.name, source.name, source.overrides, trials.seed, program.trials, made_by),
        plugins=program.plugins,
        points=program.points,
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
    if any(identity_of(number) != known for number, known in at_one_point(program, done).items()):
        raise DiagnosticError([_differs(folder.manifest, program)])
    return [number for number in range(folder.manifest.asked) if number not in done]


def execute(
    folder: RunFolder,
    workers: Workers = None,
    on_record: OnRecord | None = None,
    finished: Sequence[TrialRecord] | None = None,
    on_drawing: OnDrawing | None = None,
) -> None:
    """Run the trials that are not finished yet; each is committed to the folder as it ends.

    finished: those that are, where they have been read already, for that takes a look at every trajectory.

    A trial that ends its worker process twice is one that has crashed.

    Raises DiagnosticError as ``pending`` does, when the folder cannot be written to, or when none of the first trials
    could begin (on a grid or in a sweep, where others may, all are run); WorkerEndedError when workers end one after
    the other. After these, as after KeyboardInterrupt, what was finished is kept and another call goes on.
    """
    with folder.held():
        if finished is None:
            finished = folder.finished()
        program = program_of_run(folder)
        numbers = pending(folder, program, finished)
        if not numbers:
            return
        _can_be_run(program)
        count = workers.workers if isinstance(workers, Dask) else workers
        if count is None:
            count = min(os.cpu_count() or 1, max(1, len(numbers) // program.world.worth_a_worker))
        count = min(count, len(numbers))
        began, seed = time.perf_counter(), folder.manifest.seed

        def spend() -> None:
            with suppress(DiagnosticError):  # how long it took is not worth hiding how it ended
                folder.spend(time.perf_counter() - began)

        tell = on_drawing or (lambda _number, _draws: None)
        identity_of, limit = identities(program, seed), program.spec.trials.wall_limit

        def crash(number: int, cause: str) -> PackedTrial:
            at, _ = program.of_trial(number)
            return crashed(at, number, identity_of(number), f"its process ended, {RUNS} times: {cause}").packed()

        if isinstance(workers, Dask):
            from graspdsl.trials.dask_crew import DaskCrew

            place = workers.scheduler or count
            trials = DaskCrew(program, source_of(folder), seed, place, tell, crash).run(numbers)
        elif count == 1:
            trials = _here(program, numbers, seed, tell)
        else:
            crew = Crew(source_of(folder), seed, count, most_together(program), limit, tell, crash)
            trials = crew.run(numbers)
        first = min(TRIALS_TO_BEGIN, folder.manifest.asked)
        barren = {record.number: record for record in finished if record.number < first and not record.has_begun}
        with interruption.at_the_end(spend), closing(trials):
            for trial in trials:
                folder.add(trial)
                if on_record is not None:
                    on_record(trial.record)
                if trial.record.number < first and not trial.record.has_begun:
                    barren[trial.record.number] = trial.record
                if len(barren) == first and program.spec.trials.grid is None and not program.points:
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


def _here(program: Program, numbers: Sequence[int], seed: int, tell: OnDrawing) -> Generator[PackedTrial, None, None]:
    with answered_for(program.plugins):
        for trial in loop_over(program).run_all(numbers, seed, tell):
            yield trial.packed(program.spec.trials.keep)
