"""How a trial's trajectory is kept: what is read comes out whole and fits its program, or it is damaged."""

from __future__ import annotations

import zlib
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import lru_cache
from io import BytesIO
from typing import Any

import numpy as np

from graspdsl.arrays import Float32Array
from graspdsl.compiler.program import Program
from graspdsl.spec.keeping import ALL, kept
from graspdsl.trials.priorities import CAUSES
from graspdsl.worlds.protocol import PARTIES

Rows = dict[str, Float32Array]  # a row a tick that is kept, by name; none where a trial ended before its first tick

PACKING = 1  # of 9: half of the time of the usual 6, for files larger by a hundredth
GZIP = 31  # as zlib has it
HEADER = 10  # bytes before the text of a header of numpy's, the last two of them its length
TICK = "tick"

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
    TICK: Channel("the number of the tick, from 0: thinned trajectories have not all of them", "1", needed=True),
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
    """What is no whole trajectory, or that of another program; says why."""


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


Layouts = Callable[[int], Layout]  # by the numbers of trials


def layouts_of(program: Program) -> Layouts:
    """The layouts of the trajectories of a program, at all points of a sweep."""
    known = dict[int, Layout]()

    def of(number: int) -> Layout:
        at, own = program.of_trial(number)
        if number - own not in known:
            known[number - own] = Layout.of(at)
        return known[number - own]

    return of


def packed(rows: Mapping[str, Float32Array], keep: str = ALL) -> bytes:
    """A trajectory as a pack holds it: numpy's file of one array, a record a tick that is kept, in gzip; no bytes of
    none. ``keep``: which ticks, as of :func:`~graspdsl.spec.keeping.kept`."""
    ticks = kept(keep, len(rows["time"])) if rows else ()
    if not len(ticks):
        return b""
    columns = {TICK: np.arange(len(rows["time"]), dtype=np.float32), **rows}
    kind = _kind(tuple((name, values.shape[1:]) for name, values in columns.items()))
    table = np.empty(len(ticks), kind)
    for name, values in columns.items():
        table[name] = values[ticks]
    return zlib.compress(_header_of(kind, len(ticks)) + table.tobytes(), PACKING, wbits=GZIP)


def unpacked(content: bytes, layout: Layout | None = None) -> Rows:
    """The arrays of a trajectory, a row a tick that was kept: all that reports and pictures need, of the shapes that
    the layout asks for; without a layout the arrays themselves must agree.

    Raises DamagedTrajectoryError for anything else.
    """
    if not content:
        return {}
    try:
        whole = zlib.decompress(content, wbits=GZIP)
        kind, shape, begins = _header(whole[: HEADER + int.from_bytes(whole[HEADER - 2 : HEADER], "little")])
        table = np.frombuffer(whole, kind, offset=begins)
    except Exception as error:  # zlib and numpy's reader of headers raise a dozen kinds
        raise DamagedTrajectoryError(str(error).lower() or type(error).__name__) from error
    if shape != table.shape or any(kind[name].base != np.float32 for name in kind.names or ()):
        raise DamagedTrajectoryError("it is no table of 32-bit numbers")
    rows = {name: np.ascontiguousarray(table[name]) for name in kind.names or ()}
    _check(rows, layout)
    return rows


@lru_cache(maxsize=64)
def _kind(shapes: tuple[tuple[str, tuple[int, ...]], ...]) -> np.dtype[Any]:
    """The kind of a record with these names, and the shape of each."""
    return np.dtype([(name, "<f4", shape) for name, shape in shapes])


@lru_cache(maxsize=1024)
def _header_of(kind: np.dtype[Any], count: int) -> bytes:
    """What a file of numpy's begins with that holds so many records."""
    stream = BytesIO()
    described = np.lib.format.dtype_to_descr(kind)
    np.lib.format.write_array_header_1_0(stream, {"descr": described, "fortran_order": False, "shape": (count,)})
    return stream.getvalue()


@lru_cache(maxsize=1024)
def _header(content: bytes) -> tuple[np.dtype[Any], tuple[int, ...], int]:
    """What the header of a file of numpy's says: the kind of its records, its shape, and where these begin. To read it
    takes longer than all the rest, and most are the same."""
    stream = BytesIO(content)
    np.lib.format.read_magic(stream)
    shape, _, kind = np.lib.format.read_array_header_1_0(stream)
    return kind, shape, stream.tell()


def _check(rows: Mapping[str, Any], layout: Layout | None) -> None:
    needed = {name: channel.axes for name, channel in CHANNELS.items() if channel.needed}
    missing = [name for name in needed if name not in rows]
    if missing:
        raise DamagedTrajectoryError(f"it has no {', '.join(missing)}")
    levels = rows["observed_disturbance"].shape[-1]
    sizes = {CONTACTS: rows["touching"].shape[-1], JOINTS: rows["joints"].shape[-1], LEVELS: levels}
    if layout is not None:
        sizes = {CONTACTS: layout.contacts, JOINTS: layout.joints, LEVELS: layout.levels}
    for name, shape in needed.items():
        wanted = tuple(sizes[size] if isinstance(size, str) else size for size in shape)
        if rows[name].shape[1:] != wanted:
            raise DamagedTrajectoryError(f"a row of its {name} has the shape {rows[name].shape[1:]}, not {wanted}")
