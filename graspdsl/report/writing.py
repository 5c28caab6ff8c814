"""Files of a report, written into a folder."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from pathlib import Path

from graspdsl.diagnostics import Diagnostic, DiagnosticError
from graspdsl.trials.folders import unwritable
from graspdsl.trials.interruption import interruption
from graspdsl.trials.store import TABLE

PAGE, FIGURES = "report.html", "figures"  # of a run


def is_current(folder: Path) -> bool:
    """Whether the page in the folder of a run was made after the last of its trials was kept."""
    try:
        return (folder / PAGE).stat().st_mtime_ns > (folder / TABLE).stat().st_mtime_ns
    except OSError:
        return False


def prepare(folder: Path, files: Mapping[str, str | bytes]) -> None:
    """Make a folder, or take an empty one, and write files into it. Raises DiagnosticError where it cannot."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
        occupied = any(folder.iterdir())
    except OSError as error:
        raise unwritable(error) from error
    if occupied:
        raise DiagnosticError([Diagnostic("folder-not-empty", "this folder is not empty", hint="name another")])
    replace(folder, files)


def replace(folder: Path, files: Mapping[str, str | bytes], outdated: Sequence[str] = ()) -> None:
    """Write files into a folder and its folders, each in the place of an earlier one only once all are whole.

    Others that match the patterns ``outdated`` are removed. Raises DiagnosticError where it cannot.
    """
    try:
        with interruption.whole():
            _replace(folder, files, outdated)
    except OSError as error:
        raise unwritable(error) from error


def _replace(folder: Path, files: Mapping[str, str | bytes], outdated: Sequence[str]) -> None:
    drafts = {}
    try:
        for name, content in files.items():
            place = folder / name
            place.parent.mkdir(parents=True, exist_ok=True)
            drafts[place] = place.with_name(f"{place.name}.{os.getpid()}.new")
            drafts[place].write_bytes(content if isinstance(content, bytes) else content.encode("utf-8"))
        for place, draft in drafts.items():
            draft.replace(place)
    finally:
        for draft in drafts.values():
            draft.unlink(missing_ok=True)
    for place in {found for pattern in outdated for found in folder.glob(pattern)} - set(drafts):
        place.unlink()
