"""Folders that are written to: made, given to one only, and held against other processes."""

from __future__ import annotations

import sqlite3
from collections.abc import Iterator
from contextlib import closing, contextmanager
from pathlib import Path

from graspdsl.diagnostics import Diagnostic, DiagnosticError

LOCK = "lock"
GLANCE = 0.1  # s; who looks whether somebody has the lock has it for a moment


@contextmanager
def locked(folder: Path) -> Iterator[None]:
    """Within, nobody else gets the lock of this folder: no other process, nor this one. Who only reads needs none.

    The lock is SQLite's on an empty file, which stays: as good as that of a run's table on any file system and
    platform, and gone with its process. Raises DiagnosticError where somebody else has it, or where there can be none.
    """
    with closing(_acquired(folder)):
        yield


def is_locked(folder: Path) -> bool:
    """Whether somebody has the lock of this folder now; where there is none, or it cannot be read, nobody has."""
    try:
        with closing(sqlite3.connect(f"{(folder / LOCK).absolute().as_uri()}?mode=ro", timeout=0, uri=True)) as lock:
            lock.execute("PRAGMA schema_version")  # which cannot be read while somebody has it
    except sqlite3.Error as error:
        return getattr(error, "sqlite_errorcode", None) == sqlite3.SQLITE_BUSY
    return False


def _acquired(folder: Path) -> sqlite3.Connection:
    try:
        lock = sqlite3.connect(folder / LOCK, timeout=GLANCE, isolation_level=None)
        lock.execute("PRAGMA journal_mode = OFF")  # nothing is ever written
        lock.execute("BEGIN EXCLUSIVE")
    except sqlite3.Error as error:
        if getattr(error, "sqlite_errorcode", None) != sqlite3.SQLITE_BUSY:
            raise unwritable(error) from error
        message = "another process is writing into this folder"
        raise DiagnosticError([Diagnostic("folder-in-use", message, hint="try again when it has ended")]) from None
    return lock


def unwritable(error: OSError | sqlite3.Error) -> DiagnosticError:
    """The complaint about a folder that cannot be written to."""
    reason = (error.strerror if isinstance(error, OSError) else None) or str(error)
    message = f"cannot write to this folder: {reason.lower()}"
    return DiagnosticError([Diagnostic("folder-not-writable", message)])


def made(folder: Path) -> Path:
    """The folder, made if there is none. Raises DiagnosticError where it cannot be."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise unwritable(error) from error
    return folder


def fresh_folder(parent: Path, name: str) -> Path:
    """Makes an empty folder of this name and the next free number, ``parent/name-001``, that no other run gets.

    Raises DiagnosticError where it cannot be made.
    """
    number = 1
    try:
        parent.mkdir(parents=True, exist_ok=True)
        while True:
            folder = parent / f"{name}-{number:03d}"
            try:
                folder.mkdir()
            except FileExistsError:
                number += 1
            else:
                return folder
    except OSError as error:
        raise unwritable(error) from error
