"""Runs removed, once somebody has said that they may be."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from pathlib import Path

import typer

from graspdsl.cli.messages import result, say
from graspdsl.diagnostics import Diagnostic, DiagnosticError, on_one_line, reading
from graspdsl.report.removal import remove
from graspdsl.report.run_list import ListedRun, listed_runs, size_said
from graspdsl.trials.folders import is_locked
from graspdsl.trials.store import RunFolder


def remove_runs(paths: Sequence[Path], *, sure: bool) -> None:
    """Remove runs; at a terminal that is asked for first. Raises DiagnosticError, before anything is removed, where one
    of them is no run or is being run."""
    folders = {path.resolve(): _removable(path) for path in paths}
    if not sure:
        if sys.stdin is None or not (sys.stdin.isatty() and sys.stderr.isatty()):
            raise typer.BadParameter("there is nobody to ask: give --yes", param_hint="--yes")
        for folder in folders.values():
            say(on_one_line(f"  {_said(listed_runs(folder.path)[0])}"))
        if not typer.confirm("Remove what they hold?" if len(folders) > 1 else "Remove what it holds?", err=True):
            say("nothing was removed")
            return
    for folder in folders.values():
        with reading(str(folder.path)):
            left = remove(folder)
        result(on_one_line(f"removed: {folder.path}"))
        if left:
            say(on_one_line(f"not of the run, and still there: {', '.join(map(str, left))}"))


def _removable(path: Path) -> RunFolder:
    with reading(str(path)):
        folder = RunFolder.at(path)
        if is_locked(path):
            message, hint = "another process is writing into this folder", "try again when it has ended"
            raise DiagnosticError([Diagnostic("folder-in-use", message, hint=hint)])
        return folder


def _said(run: ListedRun) -> str:
    trials = f"{run.finished} of {run.asked} trials" if run.finished is not None else run.state.value
    return f"{run.path}: {run.spec}, seed {run.seed}, {trials}, {size_said(run.bytes)}"
