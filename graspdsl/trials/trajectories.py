"""The file of a trial's trajectory: what is read comes out whole and fits its program, or the file is damaged."""

from __future__ import annotations

import zipfile
from collections.abc import Mapping
from dataclasses import dataclass
from io import BytesIO
from pathlib import Path
from typing import Any

import numpy as np

from graspdsl.arrays import Float32Array
from graspdsl.compiler.program import Program
from graspdsl.trials.priorities import CAUSES
from graspdsl.worlds.protocol import PARTIES

Rows = dict[str, Float32Array]  # one row a tick, by name; none where a trial ended before its first tick

PACKING = 1  # of 9: half of the time of the usual 6, for files larger by a hundredth

CONTACTS, JOINTS, LEVELS = "contacts", "joints", "levels"  # axes, as long as there are of these
_OF_LEVELS = "; NaN for those of other stages"
_SENSED = "of what the level senses: 1, m, N, N·m or rad"


@dataclass(frozen=True, slots=True)
class Channel:
    """An array of a trajectory: what it tells, its unit, its axes after that of the ticks, and whether reports or
    pictures need it."""

    about: str
    unit: str
    axes: tuple[int | str, ...] = ()
    needed: bool = False


_POINTS = (CONTACTS, 3)
CHANNELS: Mapping[str, Channel] = {
    "time": Channel("the world's time since the trial began", "s", needed=True),
    "phase": Channel("the phase of the program, from 0", "1", needed=True),
    "stage": Channel("the stage, from 0 over all phases: of 'a then b' each is one", "1", needed=True),
    "force_residual": Channel("‖ρ_f‖ of the true contacts", "1", needed=True),
    "moment_residual": Channel("‖ρ_m‖ of the true contacts, about their centroid", "m", needed=True),
    "orientation": Channel("angle of the grasp against the object's axis, 0 to π/2", "rad"),
    "sensed_force_residual": Channel("ρ_f as the controller senses it", "1", (3,)),
    "sensed_moment_residual": Channel("ρ_m as the controller senses it", "m", (3,)),
    "null_space_ranks": Channel("dimensions of the null spaces of lower priorities" + _OF_LEVELS, "1", (LEVELS,)),
    "predicted_disturbance": Channel(
        "what the command does to each level beyond what it alone would have done, by its Jacobian" + _OF_LEVELS,
        "of what its Jacobian tells: 1, m, m² of pressed moments or rad",
        (LEVELS,),
    ),
    "observed_disturbance": Channel(
        "what the level senses at the next tick beyond what it alone would have done by its Jacobian" + _OF_LEVELS,
        _SENSED,
        (LEVELS,),
        needed=True,
    ),
    "disturbance_by_cause": Channel(
        "the shares in what was observed, which sum to it, of " + ", ".join(CAUSES) + _OF_LEVELS,
        _SENSED,
        (LEVELS, len(CAUSES)),
    ),
    "joints": Channel("joints, in command order", "rad, m of a slide", (JOINTS,), needed=True),
    "touching": Channel("1 where a contact feels that it touches, else 0", "1", (CONTACTS,), needed=True),
    "sensed_points": Channel("contact points as the hand senses them, the world's frame", "m", _POINTS),
    "sensed_normals": Channel("inward unit normals as the hand senses them", "1", _POINTS),
    "sensed_forces": Channel("contact forces on the object as the hand senses them", "N", _POINTS),
    "points": Channel("true contact points; sensed ones where a contact does not touch", "m", _POINTS, needed=True),
    "normals": Channel("true inward normals; sensed ones where a contact does not touch", "1", _POINTS, needed=True),
    "forces": Channel("true forces on the object; NaN where a contact does not touch", "N", _POINTS, needed=True),
    "object_position": Channel("the object's centre of mass", "m", (3,), needed=True),
    "object_rotation": Channel("rotation of the object's frame", "1", (3, 3), needed=True),
    "object_axis": Channel("the object's major axis, a unit vector", "1", (3,)),
    "loads": Channel(
        f"what {', '.join(PARTIES)} put on the object, force, then moment about its centre of mass; NaN where not told",
        "N, N·m of a moment",
        (len(PARTIES), 6),
    ),
}


class DamagedTrajectoryError(Exception):
    """A file that holds no whole trajectory, or that of another program; says why."""


@dataclass(frozen=True, slots=True)
class Layout:
    """What the trajectories of a program have in common: contacts, recorded joints, and the most levels of a stage that
    others are subject to."""

    contacts: int
    joints: int
    levels: int

    @classmethod
    def of(cls, program: Program) -> Layout:
        """The layout of a program's trajectories."""
        levels = max(len(pipeline.priorities) for stages in program.pipelines() for pipeline in stages)
        joints = len(program.robot.joints) if program.world.has("hand") else 0
        return cls(len(program.robot.contacts), joints, levels)


def write_trajectory(path: Path, rows: Mapping[str, Float32Array]) -> None:
    """Write the arrays of a trajectory, packed, into a file as numpy's savez_compressed does, but with as little effort
    as packs numbers hardly less. Raises OSError."""
    packed = BytesIO()
    with zipfile.ZipFile(packed, "w") as archive:
        for name, array in rows.items():
            content = BytesIO()
            np.lib.format.write_array(content, array, allow_pickle=False)
            undated = zipfile.ZipInfo(f"{name}.npy")  # so that the same trial makes the same file
            archive.writestr(undated, content.getvalue(), zipfile.ZIP_DEFLATED, PACKING)
    path.write_bytes(packed.getbuffer())


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
    needed = {name: channel.axes for name, channel in CHANNELS.items() if channel.needed}
    missing = [name for name in needed if name not in rows]
    if missing:
        raise DamagedTrajectoryError(f"it has no {', '.join(missing)}")
    if len({np.shape(values)[:1] for values in rows.values()}) != 1:
        raise DamagedTrajectoryError("its arrays have not as many rows")
    levels = rows["observed_disturbance"].shape[-1]
    sizes = {CONTACTS: rows["touching"].shape[-1], JOINTS: rows["joints"].shape[-1], LEVELS: levels}
    if layout is not None:
        sizes = {CONTACTS: layout.contacts, JOINTS: layout.joints, LEVELS: layout.levels}
    for name, shape in needed.items():
        wanted = tuple(sizes[size] if isinstance(size, str) else size for size in shape)
        if rows[name].shape[1:] != wanted:
            raise DamagedTrajectoryError(f"a row of its {name} has the shape {rows[name].shape[1:]}, not {wanted}")
