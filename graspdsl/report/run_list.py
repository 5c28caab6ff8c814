"""The runs in a folder: what each is of, how far it is and how it goes, found without a look at single trials."""

from __future__ import annotations

import enum
import os
from collections.abc import Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path

from graspdsl.diagnostics import Diagnostic, DiagnosticError
from graspdsl.places.files import MAP_DATA, RUN_MANIFEST
from graspdsl.report.statistics import Interval, wilson
from graspdsl.report.tables import TEXT, Column, Format, Table
from graspdsl.report.wording import percent
from graspdsl.trials.folders import is_locked
from graspdsl.trials.outcomes import Outcome
from graspdsl.trials.store import SPEC, RunFolder

DEPTH = 2  # a command that makes several runs puts them into a folder of their own
_UNITS = ((1e9, "GB"), (1e6, "MB"), (1e3, "kB"))


class State(enum.StrEnum):
    """How a run is: ``outdated`` ones are of another layout, ``damaged`` ones cannot be read."""

    COMPLETE = "complete"
    UNFINISHED = "unfinished"
    RUNNING = "running"
    OUTDATED = "outdated"
    DAMAGED = "damaged"


@dataclass(frozen=True, slots=True)
class ListedRun:
    """A run at a glance: its folder, by what name it is listed, when it was begun (by the time of its spec's file), the
    name of its spec, its seed, how many trials it has of how many asked for, the share of those that converged with a
    Wilson interval of 95 %, and its size on disk. None for what cannot be read."""

    path: str
    name: str
    state: State
    begun: str | None = None
    spec: str | None = None
    seed: int | None = None
    asked: int | None = None
    finished: int | None = None
    converged: int | None = None
    share: float | None = None
    interval: Interval | None = None
    bytes: int = 0


def listed_runs(folder: Path) -> list[ListedRun]:
    """The runs in a folder and in its folders, or the folder itself where it is one; the latest last.

    They may be written to meanwhile. Raises DiagnosticError where there is no such folder, or it may not be read.
    """
    try:
        found = [_listed(path, folder) for path in _runs_in(folder)]
    except OSError as error:
        if isinstance(error, FileNotFoundError):
            refusal = Diagnostic("folder-not-found", "there is no such folder", hint="begin a run: graspdsl run SPEC")
        else:
            message = f"cannot look into this folder: {(error.strerror or 'unknown reason').lower()}"
            refusal = Diagnostic("folder-not-readable", message, hint="name another folder")
        raise DiagnosticError([refusal], str(folder)) from None
    return sorted(found, key=lambda run: (run.begun or "", run.name))


def _runs_in(folder: Path) -> Iterator[Path]:
    if (folder / RUN_MANIFEST).exists():
        yield folder
        return
    with os.scandir(folder) as entries:
        waiting = [(Path(entry.path), 1) for entry in entries if entry.is_dir()]
    for path, depth in waiting:
        if (path / RUN_MANIFEST).exists():
            yield path
        elif depth < DEPTH and not (path / MAP_DATA).exists():
            with suppress(OSError), os.scandir(path) as entries:  # one that may not be looked at holds nothing to list
                waiting += [(Path(entry.path), depth + 1) for entry in entries if entry.is_dir()]


def _listed(path: Path, within: Path) -> ListedRun:
    name = str(path.relative_to(within)) if path != within else path.name or str(path)
    size, running = _size(path), is_locked(path)
    try:
        folder = RunFolder.at(path)
    except DiagnosticError:
        return ListedRun(str(path), name, State.DAMAGED, bytes=size)
    manifest = folder.manifest
    known = (_begun(path), manifest.name, manifest.seed, manifest.asked)
    try:
        outcomes = folder.outcomes()
    except DiagnosticError as error:
        codes = {fault.code for fault in error.diagnostics}
        state = State.OUTDATED if "run-differs" in codes else State.RUNNING if "run-in-use" in codes else State.DAMAGED
        return ListedRun(str(path), name, state, *known, bytes=size)
    finished, converged = sum(outcomes.values()), outcomes.get(Outcome.CONVERGED.value, 0)
    if running:
        state = State.RUNNING
    elif finished > manifest.asked or not (path / SPEC).is_file():
        state = State.DAMAGED
    else:
        state = State.COMPLETE if finished == manifest.asked else State.UNFINISHED
    share = converged / finished if finished else None
    interval = wilson(converged, finished) if finished else None
    return ListedRun(str(path), name, state, *known, finished, converged, share, interval, size)


def _begun(path: Path) -> str | None:
    """When a run was begun: the file of its spec is written then, and never again."""
    try:
        at = (path / SPEC).stat().st_mtime
    except OSError:
        return None
    return datetime.fromtimestamp(at, UTC).isoformat(timespec="seconds")


def _size(path: Path) -> int:
    total = 0
    for within, _, files in os.walk(path):
        for file in files:
            with suppress(OSError):  # one that went meanwhile
                total += os.lstat(os.path.join(within, file)).st_size
    return total


def runs_table(runs: Sequence[ListedRun], title: str) -> Table:
    """The runs, a row each; seeds and sizes, for which a terminal is too narrow, are in the document."""
    rows = tuple(
        (
            run.name,
            run.begun,
            run.spec,
            _trials(run),
            _share(run),
            run.state.value,
        )
        for run in runs
    )
    columns = (
        Column("run"),
        Column("begun", _WHEN),
        Column("spec"),
        Column("trials", TEXT),
        Column("converged", TEXT),
        Column("state"),
    )
    return Table(title, columns, rows)


def _trials(run: ListedRun) -> str | None:
    """How many trials there are, and of how many, where it has not all."""
    if run.finished is None or run.finished == run.asked:
        return None if run.finished is None else str(run.finished)
    return f"{run.finished} of {run.asked}"


def _share(run: ListedRun) -> str | None:
    """The share that converged, and its interval."""
    if run.share is None or run.interval is None:
        return None
    low, high = run.interval
    return f"{percent(run.share)} ({100 * low:.0f}–{100 * high:.0f})"


def size_said(size: float) -> str:
    """A number of bytes, in words."""
    for scale, unit in _UNITS:
        if size >= scale:
            return f"{size / scale:.1f} {unit}"
    return f"{size:.0f} B"


_WHEN = Format(lambda at: f"{datetime.fromisoformat(at).astimezone():%Y-%m-%d}", words=True)  # where the reader is
