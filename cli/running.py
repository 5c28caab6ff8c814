"""Runs on the command line: their folders, and their ends, good or not."""

from __future__ import annotations

import shlex
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path

from graspdsl.api import runs, sweeps
from graspdsl.api.progress import TrialProgress
from graspdsl.api.runs import Run
from graspdsl.api.sweeps import Sweep
from graspdsl.cli.messages import complain, if_interrupted, result, result_json, say
from graspdsl.cli.tables import summary_text, sweep_text
from graspdsl.compiler.program import Program
from graspdsl.diagnostics import Diagnostic, DiagnosticError, Severity, on_one_line, reading
from graspdsl.places.files import read_text
from graspdsl.report.experiment_setups import departure
from graspdsl.report.summary import plain
from graspdsl.report.writing import PAGE, is_current
from graspdsl.trials.folders import fresh_folder
from graspdsl.trials.interruption import INTERRUPTED, interruption
from graspdsl.trials.runner import execute, new_run
from graspdsl.trials.store import RunFolder
from graspdsl.trials.workers import WorkerEndedError, Workers

RUNS = Path("runs")


def begin(command: str, program: Program, out: Path | None) -> RunFolder:
    """The folder of a new run, which ``command --resume`` goes on with; DiagnosticError where there can be none."""
    name = program.spec.name if command == "run" else f"{program.spec.name}-{command}"
    with reading(str(out or RUNS)), interruption.whole():
        folder = new_run(out or fresh_folder(RUNS, name), program)
        if_interrupted(kept(*resuming(command, folder)))
    return folder


def resuming(command: str, folder: RunFolder) -> list[str]:
    """The command that goes on with a run."""
    return [command, "--resume", str(folder.path), *(["--allow-code"] if folder.allow_code else [])]


def opened(path: Path, *, allow_code: bool = False) -> Run:
    """The run in a folder; warnings go to stderr. Raises DiagnosticError as :func:`graspdsl.open_run`."""
    run, warnings = runs.opened(path, allow_code=allow_code)
    complain(str(path), "", warnings)
    return run


def opened_either(path: Path, *, allow_code: bool = False) -> Run | Sweep:
    """The run, or the sweep, in a folder, as :func:`opened`."""
    run, warnings = sweeps.opened_either(path, allow_code=allow_code)
    complain(str(path), "", warnings)
    return run


def go_on(path: Path, spec: Path | None, *, allow_code: bool = False) -> Run | Sweep:
    """A run to be finished; the spec, if named too, must be the one it was made from."""
    if_interrupted(kept("run", "--resume", str(path)))
    run = opened_either(path, allow_code=allow_code)
    if spec is not None:
        with reading(str(spec)):
            given = read_text(spec)
        if given != run.folder.spec_text:
            message, hint = f"this is not the spec that {path} was run from", "leave it out: --resume knows its own"
            raise DiagnosticError([Diagnostic("run-differs", message, hint=hint)], str(spec))
    return run


def finish(run: Run | Sweep, workers: Workers, as_json: bool, *, page: bool) -> int:
    """Run what is not finished, show progress, then the summary; make its page if asked. Returns the exit code."""
    words = resuming("run", run.folder)
    with keeping(run.path, *words):
        code = carried_on(run, workers, *words)
        if code == 0:
            current = page and is_current(run.path)
            show(run, as_json, page=page and not current)
            if current:
                say(f"report: {on_one_line(str(run.path / PAGE))}")
    return code


@contextmanager
def keeping(path: Path, *command: str) -> Iterator[None]:
    """What ends within, by a signal or since the folder cannot be written to, says what is kept and how to go on."""
    if_interrupted(kept(*command))
    try:
        with reading(str(path)):
            yield
    except DiagnosticError as error:
        hint = kept(*command, when="Once that is mended, to go on", gap=" ")
        faults = [replace(fault, hint=fault.hint or hint) for fault in error.diagnostics]
        raise DiagnosticError(faults, error.name, error.source) from None


def carried_on(run: Run | Sweep, workers: Workers, *command: str) -> int:
    """Run what is not finished and show progress. Returns the exit code; ``command`` is the one that would go on."""
    folder, manifest = run.folder, run.folder.manifest
    with reading(str(folder.path)), folder.held():
        finished = folder.finished()
        what = f"{manifest.asked} {'trial' if manifest.asked == 1 else 'trials'}, seed {manifest.seed}"
        what += f", at {len(manifest.points)} points" if manifest.points else ""
        state = f", {len(finished)} finished before" if finished else ""
        say(f"{manifest.name}: {what}{state} → {on_one_line(str(folder.path))}")
        try:
            with TrialProgress(manifest.asked, finished, say) as progress:
                execute(folder, workers, progress.advance, finished, progress.draw_again)
        except WorkerEndedError as end:
            say(f"{end}; {kept(*command)}")
            if not end.from_outside:
                raise
            return INTERRUPTED
    return 0


def show(run: Run | Sweep, as_json: bool, *, page: bool = True) -> None:
    """The summary of a run, on stdout, and if asked its page in its folder; where there can be none, a warning."""
    if as_json:
        result_json(plain(run.summary))
    else:
        result(sweep_text(run.summary) if isinstance(run, Sweep) else summary_text(run.summary))
    if differs := departure(run.program):
        say(f"the chapter's claims about {run.name} are not asked of this run: {differs}")
    if not page:
        return
    try:
        say(f"report: {on_one_line(str(run.report()))}")
    except DiagnosticError as error:
        told = [replace(diagnostic, severity=Severity.WARNING) for diagnostic in error.diagnostics]
        complain(str(run.path), "", told)


def kept(*command: str, when: str = "To go on", gap: str = "\n  ") -> str:
    """That finished trials are kept, and the command that goes on."""
    return f"finished trials are kept. {when}:{gap}{on_one_line(shlex.join(['graspdsl', *command]))}"
