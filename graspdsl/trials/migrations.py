"""Runs of earlier layouts made ones of the present: until 0.3.0 each trial had a file of its trajectory, and only that
told which contacts touched at its end."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from graspdsl.diagnostics import DiagnosticError
from graspdsl.trials.packs import Piece
from graspdsl.trials.runner import program_of_run
from graspdsl.trials.store import LAYOUT, PIECES, RunFolder, layout_of
from graspdsl.trials.trajectories import DamagedTrajectoryError, packed, unpacked

OF_ONE_TRIAL = "[0-9]*.npz"  # trajectories/3.npz


def migrate(folder: RunFolder) -> tuple[int, int]:
    """Put the trajectories of a run of an earlier layout into packs, and their ends into the table. Returns of how many
    trials there are, and of how many files could not be read: such trials are run again when the run is resumed.

    The run must be locked. Until the table is of the present layout, it is as it was; raises OSError or sqlite3.Error,
    and DiagnosticError where the run's spec cannot be read.
    """
    contacts = [list(phase.grasp.contacts) for phase in program_of_run(folder).phases]
    with folder.table() as table:
        in_packs = layout_of(table)[0] == LAYOUT
        pieces = [Piece(*row) for row in table.execute("SELECT * FROM trajectories")] if in_packs else []
    files = [] if in_packs else sorted(folder.packs.folder.glob(OF_ONE_TRIAL))
    if not in_packs:
        for begun in folder.packs.all():
            begun.unlink()  # of a migration that did not come to its end
    for file in files:
        try:
            number, content = int(file.stem), _packed(file)
        except (ValueError, DamagedTrajectoryError):
            continue
        pieces.append(folder.packs.put(number, content))
    touching = [(json.dumps(_touching(folder, piece, contacts)), piece.number) for piece in pieces]
    with folder.table() as table:
        table.execute("BEGIN")
        table.execute("DROP TABLE IF EXISTS trajectories")
        table.execute(f"CREATE TABLE trajectories ({PIECES})")
        table.executemany("INSERT INTO trajectories VALUES (?, ?, ?, ?)", pieces)
        table.execute("ALTER TABLE trials ADD COLUMN touching DEFAULT '[]'")
        table.executemany("UPDATE trials SET touching = ? WHERE number = ?", touching)
        table.execute(f"PRAGMA user_version = {LAYOUT}")
    for file in files:
        file.unlink()
    return len(pieces), len(files) - len(pieces) if files else 0


def _touching(folder: RunFolder, piece: Piece, contacts: Sequence[Sequence[int]]) -> list[bool]:
    """Which of the ``contacts`` of the last phase of a trial touched at its end; none where nothing tells."""
    try:
        rows = folder.unpacked(piece)
    except DiagnosticError:
        return []
    if not rows:
        return []
    touched = np.isfinite(rows["forces"][-1]).all(axis=-1)
    return [bool(touched[contact]) for contact in contacts[int(rows["phase"][-1])]]


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
