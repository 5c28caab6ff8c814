"""The file of a trial's trajectory, read with every doubt: what comes out is whole and fits, or it is damaged."""

from __future__ import annotations

import io
import math
import stat
import zipfile
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from graspdsl.arrays import Float32Array
from graspdsl.compiler.program import Program
from graspdsl.trials.record import LARGEST_VALUE

Rows = dict[str, Float32Array]  # one row a tick, by name; none where a trial ended before its first tick

LARGEST_FILE = 512 * 1024 * 1024  # bytes, packed or not
AFTER_LIMIT = 60.0  # s that the last probe of a phase may go on after its time was up
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
_ALWAYS_KNOWN = ("time", "phase", "touching", "joints")


class DamagedTrajectoryError(Exception):
    """A file that holds no whole trajectory, or that of another program; says why."""


@dataclass(frozen=True, slots=True)
class Layout:
    """What the trajectories of a program have in common: contacts, recorded joints, phases, and the time [s] at which
    every phase is past its limit."""

    contacts: int
    joints: int
    phases: int
    limit: float

    @classmethod
    def of(cls, program: Program) -> Layout:
        """The layout of a program's trajectories."""
        joints = len(program.robot.joints) if program.world.has("hand") else 0
        limit = math.fsum(phase.limit + AFTER_LIMIT for phase in program.spec.program)
        return cls(len(program.robot.contacts), joints, len(program.phases), limit)


def write_trajectory(path: Path, rows: Mapping[str, Float32Array]) -> None:
    """Write the arrays of a trajectory, packed, into a file. Raises OSError."""
    with path.open("wb") as stream:
        np.savez_compressed(stream, **dict(rows))  # type: ignore[arg-type]  # numpy types names like its own option


def read_trajectory(path: Path, layout: Layout | None = None) -> Rows:
    """The arrays of a trajectory: all that reports and pictures need, equally long, of the shapes that the layout asks
    for, without values that cannot be; residuals and what belongs to contacts may be NaN.

    Without a layout only the arrays themselves must agree. Raises DamagedTrajectoryError for anything else.
    """
    try:
        rows = _arrays(path)
    except DamagedTrajectoryError:
        raise
    except Exception as error:  # zipfile, its decompressors and numpy's reader of headers raise a dozen kinds
        reason = error.strerror if isinstance(error, OSError) and error.strerror else str(error)
        raise DamagedTrajectoryError(reason.lower() or type(error).__name__) from error
    if rows:
        _check_shapes(rows, layout)
        _check_values(rows, layout)
    return rows


def _arrays(path: Path) -> Rows:
    mode = path.stat()
    if not stat.S_ISREG(mode.st_mode):
        raise DamagedTrajectoryError("it is not a regular file")  # a pipe may never end
    if mode.st_size > LARGEST_FILE:
        raise DamagedTrajectoryError(f"it is too large: {mode.st_size} bytes")
    with zipfile.ZipFile(path) as archive:
        members = archive.infolist()
        unpacked = sum(member.file_size for member in members)
        if unpacked > LARGEST_FILE:
            raise DamagedTrajectoryError(f"it is too large: {unpacked} bytes when unpacked")
        return {member.filename.removesuffix(".npy"): _array(archive.read(member)) for member in members}


def _array(content: bytes) -> Float32Array:
    """An array of the one kind that trials write, its size believed only where the bytes are there."""
    stream = io.BytesIO(content)
    if np.lib.format.read_magic(stream) != (1, 0):
        raise DamagedTrajectoryError("it holds an array of another format")
    shape, by_columns, kind = np.lib.format.read_array_header_1_0(stream)
    if by_columns or kind != np.float32:
        raise DamagedTrajectoryError(f"it holds an array of {kind}, not of float32 by rows")
    return np.frombuffer(content, np.float32, offset=stream.tell()).reshape(shape)


def _check_shapes(rows: Rows, layout: Layout | None) -> None:
    missing = [name for name in _SHAPES if name not in rows]
    if missing:
        raise DamagedTrajectoryError(f"it has no {_listed(missing)}")
    if any(values.ndim == 0 for values in rows.values()) or len({len(values) for values in rows.values()}) != 1:
        raise DamagedTrajectoryError("its arrays have not as many rows")
    if len(rows["time"]) == 0:
        raise DamagedTrajectoryError("it has no rows")
    sizes = {_CONTACTS: rows["touching"].shape[-1], _JOINTS: rows["joints"].shape[-1]}
    if layout is not None:
        sizes = {_CONTACTS: layout.contacts, _JOINTS: layout.joints}
    for name, shape in _SHAPES.items():
        wanted = tuple(sizes[size] if isinstance(size, str) else size for size in shape)
        if rows[name].shape[1:] != wanted:
            raise DamagedTrajectoryError(f"a row of its {name} has the shape {rows[name].shape[1:]}, not {wanted}")


def _check_values(rows: Rows, layout: Layout | None) -> None:
    time, phase = rows["time"], rows["phase"]
    large = [name for name, values in rows.items() if (np.isfinite(values) & (np.abs(values) > LARGEST_VALUE)).any()]
    unknown = [name for name in _ALWAYS_KNOWN if not np.isfinite(rows[name]).all()]
    if large or unknown:
        raise DamagedTrajectoryError(f"it has impossible values of {_listed(large or unknown)}")
    if time[0] < 0 or (np.diff(time) < 0).any() or (layout is not None and time[-1] > layout.limit):
        raise DamagedTrajectoryError("its times cannot be")
    if (phase < 0).any() or (phase % 1 != 0).any() or (layout is not None and phase.max() >= layout.phases):
        raise DamagedTrajectoryError("its phases cannot be")


def _listed(names: Iterable[str]) -> str:
    return ", ".join(names)
