"""Files of trajectories: whole ones come back, all others are said to be damaged, at once."""

from __future__ import annotations

import io
import os
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
    LARGEST_FILE,
    DamagedTrajectoryError,
    Layout,
    Rows,
    read_trajectory,
    write_trajectory,
)
from trials.whole import whole_rows

LAYOUT = Layout(contacts=3, joints=10, phases=1, limit=30.0)
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
    folder = new_run(tmp_path / "run", program, text, SPEC.name, overrides)
    execute(folder, 1)
    rows = folder.trajectory(0, Layout.of(program))
    assert rows["points"].shape == (len(rows["time"]), len(program.robot.contacts), 3)


CHANGES: dict[str, tuple[Callable[[Rows], Any], str]] = {
    "an array is missing": (lambda rows: rows.pop("forces"), "it has no forces"),
    "of objects": (lambda rows: rows.update(time=np.array([None] * 5)), "it holds an array of object"),
    "of texts": (lambda rows: rows.update(time=np.array(["1"] * 5)), "it holds an array of <U1"),
    "of integers": (lambda rows: rows.update(phase=np.zeros(5, np.int64)), "it holds an array of int64"),
    "of structures": (lambda rows: rows.update(time=np.zeros(5, [("x", "f4")])), "it holds an array of [('x'"),
    "by columns": (lambda rows: rows.update(points=np.asfortranarray(rows["points"])), "not of float32 by rows"),
    "fewer rows": (lambda rows: rows.update(time=rows["time"][:3]), "its arrays have not as many rows"),
    "a single number": (lambda rows: rows.update(time=np.float32(1.0)), "its arrays have not as many rows"),
    "no rows": (lambda rows: rows.update({name: values[:0] for name, values in rows.items()}), "it has no rows"),
    "another hand": (lambda rows: rows.update(joints=rows["joints"][:, :4]), "a row of its joints has the shape (4,)"),
    "other contacts": (lambda rows: rows.update(whole_rows(5, contacts=8)), "a row of its touching has the shape (8,)"),
    "other axes": (
        lambda rows: rows.update(points=rows["points"][..., :2]),
        "a row of its points has the shape (3, 2)",
    ),
    "time is not a number": (lambda rows: rows["time"].fill(np.nan), "it has impossible values of time"),
    "joints without end": (lambda rows: rows["joints"].fill(np.inf), "it has impossible values of joints"),
    "a huge force": (lambda rows: rows["forces"].fill(1e36), "it has impossible values of forces"),
    "time goes back": (lambda rows: rows.update(time=-rows["time"]), "its times cannot be"),
    "a trial of a year": (lambda rows: rows["time"][4:].fill(3e7), "its times cannot be"),
    "a phase that there is not": (lambda rows: rows["phase"].fill(1), "its phases cannot be"),
    "half a phase": (lambda rows: rows["phase"].fill(0.5), "its phases cannot be"),
    "a phase before the first": (lambda rows: rows["phase"].fill(-1), "its phases cannot be"),
}


@pytest.mark.parametrize("change", CHANGES)
def test_arrays_that_no_trial_writes(change: str, tmp_path: Path) -> None:
    alter, reason = CHANGES[change]
    rows = whole_rows(5)
    alter(rows)
    (tmp_path / "0.npz").write_bytes(packed(rows))
    assert reason in refused(tmp_path / "0.npz")


def test_more_than_memory_is_neither_believed_nor_unpacked(tmp_path: Path) -> None:
    """A header that speaks of a petabyte, and a file that would unpack to more than is allowed."""
    path, header = tmp_path / "0.npz", io.BytesIO()
    claim = {"descr": "<f4", "fortran_order": False, "shape": (2**48,)}
    np.lib.format.write_array_header_1_0(header, claim)
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr("time.npy", header.getvalue())
    refused(path)
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive, archive.open("time.npy", "w") as member:
        for _ in range(LARGEST_FILE // 2**24 + 1):
            member.write(bytes(2**24))
    assert "when unpacked" in refused(path)


@pytest.mark.parametrize("place", ["nothing", "pipe", "folder", "loop", "large"])
def test_what_is_no_file(place: str, tmp_path: Path) -> None:
    path = tmp_path / "0.npz"
    match place:
        case "pipe":
            os.mkfifo(path)
        case "folder":
            path.mkdir()
        case "loop":
            path.symlink_to(path)
        case "large":
            with path.open("wb") as file:
                file.truncate(LARGEST_FILE + 1)
    assert refused(path)


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
