"""Files of trajectories: whole ones come back, all others are said to be damaged."""

from __future__ import annotations

import io
import random
import zipfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from graspdsl.compiler.program import program_of
from graspdsl.trials.runner import execute, new_run
from graspdsl.trials.trajectories import (
    CHANNELS,
    CONTACTS,
    JOINTS,
    LEVELS,
    DamagedTrajectoryError,
    Layout,
    Rows,
    read_trajectory,
    write_trajectory,
)
from trials.whole import whole_rows

LAYOUT = Layout(contacts=3, joints=10, levels=2)
SPEC = Path(__file__).parents[2] / "specs" / "compare" / "moment_subject_to_force.yaml"


def packed(rows: Any, method: int = zipfile.ZIP_DEFLATED) -> bytes:
    """Arrays in a file of numpy's, packed by a method of its own choice."""
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w", method) as archive:
        for name, values in rows.items():
            with archive.open(f"{name}.npy", "w") as member:
                np.lib.format.write_array(member, np.asanyarray(values))
    return stream.getvalue()


def refused(path: Path, layout: Layout | None = LAYOUT) -> str:
    """Why a file is refused; it must be."""
    with pytest.raises(DamagedTrajectoryError) as caught:
        read_trajectory(path, layout)
    return str(caught.value)


@pytest.mark.parametrize("layout", [LAYOUT, None])
def test_whole_rows_come_back(layout: Layout | None, tmp_path: Path) -> None:
    rows, path = whole_rows(5), tmp_path / "0.npz"
    rows["points"][2] = np.nan
    write_trajectory(path, rows)
    found = read_trajectory(path, layout)
    assert found.keys() == rows.keys()
    assert all(np.array_equal(found[name], rows[name], equal_nan=True) for name in rows)


def test_a_trial_that_ended_before_its_first_tick_has_no_rows(tmp_path: Path) -> None:
    np.savez_compressed(tmp_path / "0.npz")
    assert read_trajectory(tmp_path / "0.npz", LAYOUT) == {}


def test_a_program_lays_its_trajectories_out(tmp_path: Path) -> None:
    text, overrides = SPEC.read_text("utf-8"), ("trials.count=1",)
    program = program_of(text, SPEC.name, overrides)
    folder = new_run(tmp_path / "run", program)
    execute(folder, 1)
    rows = folder.trajectory(0, Layout.of(program))
    assert rows["points"].shape == (len(rows["time"]), len(program.robot.contacts), 3)


CHANGES: dict[str, tuple[Callable[[Rows], Any], str]] = {
    "an array is missing": (lambda rows: rows.pop("forces"), "it has no forces"),
    "fewer rows": (lambda rows: rows.update(time=rows["time"][:3]), "its arrays have not as many rows"),
    "a single number": (lambda rows: rows.update(time=np.float32(1.0)), "its arrays have not as many rows"),
    "another hand": (lambda rows: rows.update(joints=rows["joints"][:, :4]), "a row of its joints has the shape (4,)"),
    "other contacts": (lambda rows: rows.update(whole_rows(5, contacts=8)), "a row of its touching has the shape (8,)"),
    "other axes": (
        lambda rows: rows.update(points=rows["points"][..., :2]),
        "a row of its points has the shape (3, 2)",
    ),
}


@pytest.mark.parametrize("change", CHANGES)
def test_arrays_that_no_trial_writes(change: str, tmp_path: Path) -> None:
    alter, reason = CHANGES[change]
    rows = whole_rows(5)
    alter(rows)
    (tmp_path / "0.npz").write_bytes(packed(rows))
    assert reason in refused(tmp_path / "0.npz")


@pytest.mark.parametrize("place", ["nothing", "folder", "loop"])
def test_what_is_no_file(place: str, tmp_path: Path) -> None:
    path = tmp_path / "0.npz"
    match place:
        case "folder":
            path.mkdir()
        case "loop":
            path.symlink_to(path)
    assert refused(path)


@pytest.mark.slow
@pytest.mark.parametrize("method", [zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED, zipfile.ZIP_BZIP2, zipfile.ZIP_LZMA])
def test_garbled_files_are_whole_or_damaged(method: int, tmp_path: Path) -> None:
    """Whatever bytes are changed, nothing but a diagnosis comes out, and a file that is still read fits."""
    whole, path = packed(whole_rows(5), method), tmp_path / "0.npz"
    chance = random.Random(20)
    damaged = 0
    for _ in range(300):
        content = bytearray(whole)
        for _ in range(chance.randint(1, 4)):
            content[chance.randrange(len(content))] = chance.randrange(256)
        if chance.random() < 0.3:
            del content[chance.randrange(len(content)) :]
        path.write_bytes(content)
        try:
            assert read_trajectory(path, LAYOUT)["points"].shape == (5, 3, 3)
        except DamagedTrajectoryError:
            damaged += 1
    assert damaged > 200


@pytest.mark.slow
@pytest.mark.parametrize("name", ["compare/moment_subject_to_force", "chapter/4_30_grasp_cartesian"])
def test_every_array_is_told_of(name: str, tmp_path: Path) -> None:
    """What trials of either world write down are the channels there are, each with its axes and a unit."""
    spec = SPEC.parents[1] / f"{name}.yaml"
    program = program_of(spec.read_text("utf-8"), spec.name, ("trials.count=1",))
    folder = new_run(tmp_path / "run", program)
    execute(folder, workers=1)
    layout = Layout.of(program)
    sizes = {CONTACTS: layout.contacts, JOINTS: layout.joints, LEVELS: layout.levels}
    rows = folder.trajectory(0, layout)
    assert {name: rows[name].shape[1:] for name in rows} == {
        name: tuple(sizes[axis] if isinstance(axis, str) else axis for axis in channel.axes)
        for name, channel in CHANNELS.items()
    }
    assert all(channel.unit and channel.about for channel in CHANNELS.values())
