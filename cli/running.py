"""Runs on the command line: folders, progress, the end."""

from __future__ import annotations

import shlex
import sys
import time
from collections import Counter
from pathlib import Path

from graspdsl.cli.messages import result_json, say
from graspdsl.cli.tables import show_summary

from graspdsl.compiler.program import program_of
from graspdsl.diagnostics import Diagnostic, DiagnosticError
from graspdsl.report.summary import summary
from graspdsl.spec.files import read_text
from graspdsl.trials.record import Trial
from graspdsl.trials.runner import InterruptedRunError, execute, new_run
from graspdsl.trials.store import RunFolder, fresh_folder

RUNS = Path("runs")
INTERRUPTED = 130


def begin(spec: Path, text: str, overrides: tuple[str, ...], out: Path | None) -> RunFolder:
    """The folder of a new run of a sound spec."""
    program = program_of(text, spec.name, overrides)
    return new_run(out or fresh_folder(RUNS, program.spec.name), program, text, spec.name, overrides)


def go_on(path: Path, spec: Path | None) -> RunFolder:
    """The folder of a run to be finished; the spec, if named too, must be the one it was made from."""
    folder = RunFolder.open(path)
    if spec is not None and read_text(spec) != folder.spec_text:
        message = f"{spec} is not the spec that {path} was run from"
        raise DiagnosticError([Diagnostic("run-differs", message, hint="leave the spec out: --resume knows its own")])
    return folder


def finish(folder: RunFolder, workers: int | None, as_json: bool) -> int:
    """Run what is not finished, show progress, then the summary. Returns the exit code."""
    done = len(folder.records())
    say(f"{folder.manifest.name}: {folder.manifest.asked} trials, seed {folder.manifest.seed} → {folder.path}")
    progress = Progress(folder.manifest.asked, done)
    try:
        with progress:
            execute(folder, workers, progress.advance)
    except InterruptedRunError:
        say(f"interrupted; what was finished is kept. To go on: graspdsl run --resume {shlex.quote(str(folder.path))}")
        return INTERRUPTED
    numbers = summary(folder)
    if as_json:
        result_json(numbers)
    else:
        show_summary(numbers)
    return 0


class Progress:
    """Trials done, outcomes so far and time left, on stderr: a bar on a terminal, now and then a line elsewhere."""

    def __init__(self, asked: int, done: int) -> None:
        self._asked, self._before, self._done = asked, done, done
        self._outcomes: Counter[str] = Counter()
        self._began = time.monotonic()
        self._live = sys.stderr.isatty()
        self._every = max(1, asked // 10)

    def __enter__(self) -> Progress:
        return self

    def __exit__(self, *_: object) -> None:
        if self._live and self._done > self._before:
            print(file=sys.stderr)

    def advance(self, trial: Trial) -> None:
        """One more trial is finished."""
        self._done += 1
        self._outcomes[trial.record.outcome.value] += 1
        if self._live:
            print(f"\r\x1b[K{self._line()}", end="", file=sys.stderr, flush=True)
        elif self._done % self._every == 0 or self._done == self._asked:
            say(self._line())

    def _line(self) -> str:
        outcomes = ", ".join(f"{count} {name}" for name, count in self._outcomes.most_common())
        spent = time.monotonic() - self._began
        left = spent / max(1, self._done - self._before) * (self._asked - self._done)
        filled = 20 * self._done // self._asked
        bar = "█" * filled + "░" * (20 - filled)
        return f"{bar} {self._done}/{self._asked}  {outcomes}  {left:.0f} s left"
