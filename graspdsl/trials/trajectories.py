"""The file of a trial's trajectory: what is read comes out whole and fits its program, or the file is damaged."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from graspdsl.arrays import Float32Array
from graspdsl.compiler.program import Program

Rows = dict[str, Float32Array]  # one row a tick, by name; none where a trial ended before its first tick

_CONTACTS, _JOINTS = "contacts", "joints"
_SHAPES: Mapping[str, tuple[int | str, ...]] = {
    "time": (),
    "phase": (),
    "touching": (_CONTACTS,),
    "force_residual": (),
    "moment_residual": (),
    "joints": (_JOINTS,),
    "points": (_CONTACTS, 3),
    "normals": (_CONTACTS, 3),
    "forces": (_CONTACTS, 3),
    "object_position": (3,),
    "object_rotation": (3, 3),
}


class DamagedTrajectoryError(Exception):
    """A file that holds no whole trajectory, or that of another program; says why."""


@dataclass(frozen=True, slots=True)
class Layout:
    """What the trajectories of a program have in common: contacts and recorded joints."""

    contacts: int
    joints: int

    @classmethod
    def of(cls, program: Program) -> Layout:
        """The layout of a program's trajectories."""
        return cls(len(program.robot.contacts), len(program.robot.joints) if program.world.has("hand") else 0)


def write_trajectory(path: Path, rows: Mapping[str, Float32Array]) -> None:
    """Write the arrays of a trajectory, packed, into a file. Raises OSError."""
    with path.open("wb") as stream:
        np.savez_compressed(stream, **dict(rows))  # type: ignore[arg-type]  # numpy types names like its own option


def read_trajectory(path: Path, layout: Layout | None = None) -> Rows:
    """The arrays of a trajectory: all that reports and pictures need, equally long, of the shapes that the layout asks
    for; without a layout the arrays themselves must agree.

    Raises DamagedTrajectoryError for anything else.
    """
    try:
        with np.load(path, allow_pickle=False) as archive:
            rows = dict(archive)
    except Exception as error:  # zipfile, its decompressors and numpy's reader of headers raise a dozen kinds
        reason = error.strerror if isinstance(error, OSError) and error.strerror else str(error)
        raise DamagedTrajectoryError(reason.lower() or type(error).__name__) from error
    if rows:
        _check(rows, layout)
    return rows


def _check(rows: Mapping[str, Any], layout: Layout | None) -> None:
    missing = [name for name in _SHAPES if name not in rows]
    if missing:
        raise DamagedTrajectoryError(f"it has no {', '.join(missing)}")
    if len({np.shape(values)[:1] for values in rows.values()}) != 1:
        raise DamagedTrajectoryError("its arrays have not as many rows")
    sizes = {_CONTACTS: rows["touching"].shape[-1], _JOINTS: rows["joints"].shape[-1]}
    if layout is not None:
        sizes = {_CONTACTS: layout.contacts, _JOINTS: layout.joints}
    for name, shape in _SHAPES.items():
        wanted = tuple(sizes[size] if isinstance(size, str) else size for size in shape)
        if rows[name].shape[1:] != wanted:
            raise DamagedTrajectoryError(f"a row of its {name} has the shape {rows[name].shape[1:]}, not {wanted}")
