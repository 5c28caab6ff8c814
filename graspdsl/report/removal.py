"""A run removed: what it is made of, and nothing that somebody else put into its folder."""

from __future__ import annotations

import shutil
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path

from graspdsl.report.attraction import FILES as OF_A_MAP
from graspdsl.report.writing import FIGURES, PAGE
from graspdsl.trials.folders import LOCK, locked, unwritable
from graspdsl.trials.interruption import interruption
from graspdsl.trials.migrations import OF_ONE_TRIAL
from graspdsl.trials.packs import SUFFIX
from graspdsl.trials.store import MANIFEST, POINTS, SPEC, TABLE, TRAJECTORIES, RunFolder

_REPORT = (PAGE, f"{PAGE}.*.new", *(f"{FIGURES}/*.{kind}" for kind in ("svg", "png", "new")))
# The manifest first: what is left when the rest cannot be removed is no run that looks whole.
_PARTS = (
    *(MANIFEST, f"{MANIFEST}.*new", TABLE, f"{TABLE}-*", SPEC, *OF_A_MAP),
    *(f"{TRAJECTORIES}/{name}" for name in (f"*{SUFFIX}", f"*{SUFFIX}.new", OF_ONE_TRIAL)),
    *_REPORT,
    *(f"{POINTS}/*/{name}" for name in _REPORT),
)


def remove(folder: RunFolder) -> list[Path]:
    """Remove a run: its manifest, spec, table and trajectories, copies of files, report and figures, and its folder if
    that is empty then. Returns what is left there, which is nothing of the run's.

    Raises DiagnosticError where a process runs its trials, or it cannot be removed.
    """
    folder.check_whole()
    path = folder.path
    try:
        with locked(path), interruption.whole():
            for file in _made_of(path):
                file.unlink()
            if folder.files.is_dir() and not folder.files.is_symlink():
                shutil.rmtree(folder.files)
        (path / LOCK).unlink(missing_ok=True)
        of_points = [*path.glob(f"{POINTS}/*/{FIGURES}"), *path.glob(f"{POINTS}/*"), path / POINTS]
        for place in (*of_points, path / TRAJECTORIES, path / FIGURES, path):
            with suppress(OSError):  # one that is not there, or not empty
                place.rmdir()
        return sorted(path.rglob("*")) if path.exists() else []
    except OSError as error:
        raise unwritable(error) from error


def _made_of(path: Path) -> Iterator[Path]:
    for pattern in _PARTS:
        yield from (file for file in path.glob(pattern) if file.is_symlink() or file.is_file())
