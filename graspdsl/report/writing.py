"""Files of a report, written into a folder."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from graspdsl.diagnostics import Diagnostic, DiagnosticError


def prepare(folder: Path, files: Mapping[str, str | bytes]) -> None:
    """Make a folder, or take an empty one, and write files into it. Raises DiagnosticError where it cannot."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
        occupied = any(folder.iterdir())
    except OSError as error:
        raise _unwritable(error) from error
    if occupied:
        raise DiagnosticError([Diagnostic("folder-not-empty", "this folder is not empty", hint="name another")])
    write(folder, files)


def write(folder: Path, files: Mapping[str, str | bytes]) -> None:
    """Write files into a folder. Raises DiagnosticError where it cannot."""
    try:
        for name, content in files.items():
            (folder / name).write_bytes(content if isinstance(content, bytes) else content.encode("utf-8"))
    except OSError as error:
        raise _unwritable(error) from error


def _unwritable(error: OSError) -> DiagnosticError:
    reason = (error.strerror or "unknown reason").lower()
    return DiagnosticError([Diagnostic("folder-not-writable", f"cannot write to this folder: {reason}")])
