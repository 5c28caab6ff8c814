"""Runs of earlier layouts made ones of the present: until 0.3.0 each trial had a file of its trajectory."""

from __future__ import annotations

import sqlite3
from pathlib import Path

import numpy as np

from graspdsl.trials.packs import Piece
from graspdsl.trials.rows import COLUMNS
from graspdsl.trials.store import LAYOUT, PIECES, RunFolder, layout_of
from graspdsl.trials.trajectories import DamagedTrajectoryError, packed, unpacked

OF_ONE_TRIAL = "[0-9]*.npz"  # trajectories/3.npz


def is_of_earlier_layout(table: sqlite3.Connection) -> bool:
    """Whether the table is of a run that :func:`migrate` knows."""
    layout, known = layout_of(table)
    return layout < LAYOUT and known == set(COLUMNS)


def migrate(folder: RunFolder) -> tuple[int, int]:
    """Put the trajectories of a run of an earlier layout into packs. Returns of how many trials there are, and of how
    many files could not be read: such trials are run again when the run is resumed.

    The run must be locked. Until the table says where trajectories are, it is as it was; raises OSError or
    sqlite3.Error.
    """
    for begun in folder.packs.all():
        begun.unlink()  # of a migration that did not come to its end
    pieces, files = list[Piece](), sorted(folder.packs.folder.glob(OF_ONE_TRIAL))
    for file in files:
        try:
            number, content = int(file.stem), _packed(file)
        except (ValueError, DamagedTrajectoryError):
            continue
        pieces.append(folder.packs.put(number, content))
    with folder.table() as table:
        table.execute("BEGIN")
        table.execute("DROP TABLE IF EXISTS trajectories")
        table.execute(f"CREATE TABLE trajectories ({PIECES})")
        table.executemany("INSERT INTO trajectories VALUES (?, ?, ?, ?)", pieces)
        table.execute(f"PRAGMA user_version = {LAYOUT}")
    for file in files:
        file.unlink()
    return len(pieces), len(files) - len(pieces)


def _packed(file: Path) -> bytes:
    """A trajectory as a pack holds it. Raises DamagedTrajectoryError where the file holds none."""
    try:
        with np.load(file, allow_pickle=False) as archive:
            rows = dict(archive)
        if len({len(values) for values in rows.values()}) > 1 or any(one.dtype != np.float32 for one in rows.values()):
            raise ValueError("its arrays are no rows of 32-bit numbers")
        content = packed(rows)
    except Exception as error:  # zipfile, its decompressors and numpy's reader of headers raise a dozen kinds
        raise DamagedTrajectoryError(str(error)) from error
    unpacked(content)
    return content
