"""Runs on the command line: their folders, and their ends, good or not."""

from __future__ import annotations

import shlex
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path

from graspdsl.cli.messages import complain, if_interrupted, result, result_json, say
from graspdsl.cli.progress import TrialProgress
from graspdsl.cli.tables import summary_text
from graspdsl.compiler.program import Program
from graspdsl.diagnostics import Diagnostic, DiagnosticError, Severity, on_one_line, reading
from graspdsl.places.files import read_text
from graspdsl.report.claims import Claim, claims_of
from graspdsl.report.evidence import Evidence, evidence_of
from graspdsl.report.experiment_setups import departure
from graspdsl.report.outcomes import representatives
from graspdsl.report.summary import Summary, plain, summarised
from graspdsl.trials.identity import check_origin
from graspdsl.trials.interruption import INTERRUPTED, interruption
from graspdsl.trials.runner import WorkerEndedError, execute, new_run, program_of_run
from graspdsl.trials.store import SPEC, RunFolder, fresh_folder

RUNS = Path("runs")


def begin(command: str, program: Program, out: Path | None) -> RunFolder:
    """The folder of a new run, which ``command --resume`` goes on with; DiagnosticError where there can be none."""
    name = program.spec.name if command == "run" else f"{program.spec.name}-{command}"
    with reading(str(out or RUNS)), interruption.whole():
        folder = new_run(out or fresh_folder(RUNS, name), program)
        if_interrupted(kept(command, "--resume", str(folder.path)))
    return folder


def opened(path: Path) -> RunFolder:
    """The run in a folder. Raises DiagnosticError where it or its spec cannot be read, or they do not go together."""
    with reading(str(path)):
        folder = RunFolder.open(path)
        text = folder.spec_text
    with reading(str(path / SPEC), text):
        program = program_of_run(folder)
    with reading(str(path)):
        complain(str(path), "", check_origin(folder, program))
    return folder


def go_on(path: Path, spec: Path | None) -> RunFolder:
    """The folder of a run to be finished; the spec, if named too, must be the one it was made from."""
    if_interrupted(kept("run", "--resume", str(path)))
    folder = opened(path)
    if spec is not None:
        with reading(str(spec)):
            given = read_text(spec)
        if given != folder.spec_text:
            message, hint = f"this is not the spec that {path} was run from", "leave it out: --resume knows its own"
            raise DiagnosticError([Diagnostic("run-differs", message, hint=hint)], str(spec))
    return folder


def finish(folder: RunFolder, workers: int | None, as_json: bool) -> int:
    """Run what is not finished, show progress, then the summary. Returns the exit code."""
    with keeping(folder.path, "run", "--resume", str(folder.path)):
        code = carried_on(folder, workers, "run", "--resume", str(folder.path))
        if code == 0:
            show(folder, as_json)
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


def carried_on(folder: RunFolder, workers: int | None, *command: str) -> int:
    """Run what is not finished and show progress. Returns the exit code; ``command`` is the one that would go on."""
    with reading(str(folder.path)), folder.held():
        finished = folder.finished()
        manifest = folder.manifest
        what = f"{manifest.asked} {'trial' if manifest.asked == 1 else 'trials'}, seed {manifest.seed}"
        state = f", {len(finished)} finished before" if finished else ""
        say(f"{manifest.name}: {what}{state} → {on_one_line(str(folder.path))}")
        try:
            with TrialProgress(manifest.asked, finished) as progress:
                execute(folder, workers, progress.advance, finished, progress.draw_again)
        except WorkerEndedError as end:
            say(f"{end}; {kept(*command)}")
            if not end.from_outside:
                raise
            return INTERRUPTED
    return 0


def show(folder: RunFolder, as_json: bool) -> None:
    """The summary of a run, on stdout, and its page in its folder; where there can be none, a warning."""
    with reading(str(folder.path)):
        evidence = evidence_of(folder)
    summary = summarised(evidence)
    if as_json:
        result_json(plain(summary))
    else:
        result(summary_text(summary))
    if differs := departure(evidence.program):
        say(f"the chapter's claims about {folder.manifest.name} are not asked of this run: {differs}")
    try:
        say(f"report: {on_one_line(str(page_of(evidence, summary, claims_of(evidence, summary))))}")
    except DiagnosticError as error:
        told = [replace(diagnostic, severity=Severity.WARNING) for diagnostic in error.diagnostics]
        complain(str(folder.path), "", told)


def page_of(evidence: Evidence, summary: Summary, claims: Sequence[Claim]) -> Path:
    """Write a run's page; that of one of the chapter's experiments says what agrees with the chapter."""
    from graspdsl.report.page import write_report

    return write_report(evidence, summary, frames=frames_of(evidence), claims=claims)


def frames_of(evidence: Evidence) -> dict[str, bytes]:
    """A PNG picture of the end of one trial of each outcome, where one can be drawn."""
    from graspdsl.trials.replay import frame

    shown = {name: frame(evidence.folder, trial.number) for name, trial in representatives(evidence.records).items()}
    return {name: picture for name, picture in shown.items() if picture is not None}


def kept(*command: str, when: str = "To go on", gap: str = "\n  ") -> str:
    """That finished trials are kept, and the command that goes on."""
    return f"finished trials are kept. {when}:{gap}{on_one_line(shlex.join(['graspdsl', *command]))}"
