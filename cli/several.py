"""Several runs by one command, each in a folder of its own inside of one; those that were begun before go on."""

from __future__ import annotations

import shlex
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path

from graspdsl.api.runs import Run
from graspdsl.cli.running import RUNS, carried_on, keeping, opened
from graspdsl.compiler.program import Program
from graspdsl.diagnostics import Diagnostic, DiagnosticError, reading
from graspdsl.trials.folders import fresh_folder, locked, made
from graspdsl.trials.runner import new_run, pending
from graspdsl.trials.store import MANIFEST
from graspdsl.trials.workers import Dask, Workers

ANOTHER = "name another folder with --out"


@dataclass(frozen=True, slots=True)
class Asked:
    """What was asked for on the command line; ``options``: those that the command alone has."""

    command: str
    specs: tuple[Path, ...]
    settings: tuple[str, ...] = ()
    trials: int | None = None
    seed: int | None = None
    workers: Workers = None
    out: Path | None = None
    as_json: bool = False
    allow_code: bool = False
    options: tuple[str, ...] = ()

    @property
    def overrides(self) -> tuple[str, ...]:
        """The settings with those that have an option of their own."""
        named = (("trials.count", self.trials), ("trials.seed", self.seed))
        return (*self.settings, *(f"{path}={value}" for path, value in named if value is not None))

    def words(self, out: Path) -> list[str]:
        """The command that goes on with the runs in a folder."""
        options: list[tuple[str, str | int | None]] = [("--trials", self.trials), ("--seed", self.seed)]
        if isinstance(self.workers, Dask):
            of_dask = ("--workers", self.workers.workers), ("--scheduler", self.workers.scheduler)
            options += ("--engine", "dask"), *of_dask
        else:
            options += [("--workers", self.workers)]
        words = [self.command, *map(str, self.specs), *self.options]
        words += [word for name, value in options if value is not None for word in (name, str(value))]
        words += [word for setting in self.settings for word in ("--set", setting)]
        words += ["--allow-code"] if self.allow_code else []
        return [*words, "--out", str(out), *(["--json"] if self.as_json else [])]


@dataclass(frozen=True, slots=True)
class Part:
    """One of the runs: its name, which is its folder's, and the program of a spec file, checked."""

    name: str
    spec: Path
    program: Program

    @property
    def text(self) -> str:
        """The text of the spec."""
        return self.program.source.text


@contextmanager
def folder_for(parts: Sequence[Part], asked: Asked) -> Iterator[Path]:
    """The folder that all runs go into, which nobody else writes to within. Raises DiagnosticError where there is none,
    or where it holds something else than runs that this command began."""
    if asked.out is not None:
        try:
            _free_for(asked.out, parts)
        except OSError as error:
            message = f"cannot look into this folder: {(error.strerror or 'unknown reason').lower()}"
            raise DiagnosticError([Diagnostic("folder-not-readable", message, hint=ANOTHER)], str(asked.out)) from None
    with reading(str(asked.out or RUNS)):
        whole = made(asked.out) if asked.out else fresh_folder(RUNS, asked.command)
    with keeping(whole, *asked.words(whole)), locked(whole):
        yield whole


def run_each(parts: Sequence[Part], whole: Path, asked: Asked, then: Callable[[Part, Run], object]) -> int:
    """Begin or go on with the runs one after the other, and do something with each that has ended.

    Returns the exit code.
    """
    for part in parts:
        run = _begun(part, whole / part.name)
        code = carried_on(run, asked.workers, *asked.words(whole))
        if code != 0:
            return code
        then(part, run)
    return 0


def _free_for(out: Path, parts: Sequence[Part]) -> None:
    """Every run that is already in the folder must be one that this command began."""
    if (out / MANIFEST).exists():
        message = "this folder holds a run"
        raise DiagnosticError([Diagnostic("folder-not-empty", message, hint=ANOTHER)], str(out))
    for part in parts:
        place = out / part.name
        if (place / MANIFEST).exists():
            _goes_on(part, place)
        elif place.exists() and (not place.is_dir() or any(place.iterdir())):
            message = "there is something here, but no run that could go on"
            raise DiagnosticError([Diagnostic("folder-not-empty", message, hint=ANOTHER)], str(place))


def _goes_on(part: Part, place: Path) -> None:
    """A run that was begun before must have been begun in the same way."""
    begun, source = opened(place, allow_code=part.program.source.allow_code), part.program.source
    if begun.program.source.text != part.text:
        message = f"this run was begun from another spec than {part.spec}"
    elif begun.program.source.overrides != source.overrides:
        said = shlex.join(word for setting in begun.program.source.overrides for word in ("--set", setting))
        message = f"this run was begun with other settings: {said or 'none'}"
    else:
        try:
            pending(begun.folder, begun.program, begun.folder.finished())
        except DiagnosticError as error:
            faults = [replace(fault, hint=ANOTHER) for fault in error.diagnostics]
            raise DiagnosticError(faults, str(place)) from None
        return
    raise DiagnosticError([Diagnostic("run-differs", message, hint=ANOTHER)], str(place))


def _begun(part: Part, place: Path) -> Run:
    """A new run, or the one that was begun here before."""
    if (place / MANIFEST).exists():
        return opened(place, allow_code=part.program.source.allow_code)
    with reading(str(place)):
        return Run(new_run(place, part.program), part.program)
