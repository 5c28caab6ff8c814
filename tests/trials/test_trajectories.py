"""Trajectories as they are kept: whole ones come back, all others are said to be damaged."""

from __future__ import annotations

import io
import random
import zlib
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
    GZIP,
    JOINTS,
    LEVELS,
    TICK,
    DamagedTrajectoryError,
    Layout,
    Rows,
    packed,
    unpacked,
)
from trials.whole import whole_rows

LAYOUT = Layout(contacts=3, joints=10, levels=2)
SPEC = Path(__file__).parents[2] / "specs" / "compare" / "moment_subject_to_force.yaml"


def of_numpy(table: Any) -> bytes:
    """An array in a file of numpy's, in gzip."""
    stream = io.BytesIO()
    np.lib.format.write_array(stream, np.asanyarray(table), allow_pickle=True)
    return zlib.compress(stream.getvalue(), wbits=GZIP)


def refused(content: bytes, layout: Layout | None = LAYOUT) -> str:
    """Why a content is refused; it must be."""
    with pytest.raises(DamagedTrajectoryError) as caught:
        unpacked(content, layout)
    return str(caught.value)


@pytest.mark.parametrize("layout", [LAYOUT, None])
def test_whole_rows_come_back(layout: Layout | None) -> None:
    rows = whole_rows(5)
    rows["points"][2] = np.nan
    found = unpacked(packed(rows), layout)
    assert found.keys() == rows.keys()
    assert all(np.array_equal(found[name], rows[name], equal_nan=True) for name in rows)


@pytest.mark.parametrize(
    ("keep", "ticks"),
    [
        ("all", list(range(23))),
        ("every=1", list(range(23))),
        ("every=10", [0, 10, 20, 22]),
        ("every=11", [0, 11, 22]),
        ("every=100", [0, 22]),
        ("ends", [0, 22]),
        ("none", []),
    ],
)
def test_what_is_kept(keep: str, ticks: list[int]) -> None:
    rows = whole_rows(23)
    del rows[TICK]
    found = unpacked(packed(rows, keep))
    assert [round(50 * time) for time in found.get("time", [])] == [*found.get(TICK, [])] == ticks


@pytest.mark.parametrize("keep", ["all", "every=10", "ends", "none"])
def test_a_trial_that_ended_before_its_first_tick_has_no_rows(keep: str) -> None:
    assert packed({}, keep) == b""
    assert unpacked(b"", LAYOUT) == {}
    assert len(unpacked(packed(whole_rows(1), keep))) == (0 if keep == "none" else len(whole_rows(1)))


def test_the_same_rows_make_the_same_bytes() -> None:
    assert packed(whole_rows(5)) == packed(whole_rows(5))


def test_a_program_lays_its_trajectories_out(tmp_path: Path) -> None:
    text, overrides = SPEC.read_text("utf-8"), ("trials.count=1",)
    program = program_of(text, SPEC.name, overrides)
    folder = new_run(tmp_path / "run", program)
    execute(folder, 1)
    rows = folder.trajectory(0, Layout.of(program))
    assert rows["points"].shape == (len(rows["time"]), len(program.robot.contacts), 3)


CHANGES: dict[str, tuple[Callable[[Rows], Any], str]] = {
    "an array is missing": (lambda rows: rows.pop("forces"), "it has no forces"),
    "another hand": (lambda rows: rows.update(joints=rows["joints"][:, :4]), "a row of its joints has the shape (4,)"),
    "other contacts": (lambda rows: rows.update(whole_rows(5, contacts=8)), "a row of its touching has the shape (8,)"),
    "other axes": (
        lambda rows: rows.update(points=rows["points"][..., :2]),
        "a row of its points has the shape (3, 2)",
    ),
}


@pytest.mark.parametrize("change", CHANGES)
def test_arrays_that_no_trial_writes(change: str) -> None:
    alter, reason = CHANGES[change]
    rows = whole_rows(5)
    alter(rows)
    assert reason in refused(packed(rows))


@pytest.mark.parametrize(
    "content",
    [
        b"text",
        zlib.compress(b"text", wbits=GZIP),
        of_numpy(np.zeros(3)),
        of_numpy(np.zeros((2, 2), [("time", "<f4")])),
        of_numpy(np.zeros(2, [("time", "<f8")])),
        of_numpy(np.array([object()])),
    ],
)
def test_what_is_no_table_of_a_trial(content: bytes) -> None:
    assert refused(content, None)


@pytest.mark.slow
def test_garbled_contents_are_whole_or_damaged() -> None:
    """Whatever bytes are changed, nothing but a diagnosis comes out, and what is still read fits."""
    whole = packed(whole_rows(5))
    chance = random.Random(20)
    damaged = 0
    for _ in range(1200):
        content = bytearray(whole)
        for _ in range(chance.randint(1, 4)):
            content[chance.randrange(len(content))] = chance.randrange(256)
        if chance.random() < 0.3:
            del content[chance.randrange(1, len(content)) :]
        try:
            assert unpacked(bytes(content), LAYOUT)["points"].shape == (5, 3, 3)
        except DamagedTrajectoryError:
            damaged += 1
    assert damaged > 800


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
