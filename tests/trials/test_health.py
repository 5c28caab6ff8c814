"""What of a run is whole is said, and what is not is mended: after that, resuming it makes the same run again."""

from __future__ import annotations

import json
import os
import shutil
import sqlite3
from collections.abc import Callable
from contextlib import closing
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from stored_runs import lose_trajectory, stored_run
from typer.testing import CliRunner

from graspdsl.cli.app import app
from graspdsl.diagnostics import DiagnosticError
from graspdsl.trials.folders import locked
from graspdsl.trials.health import Verdict, examined, mended
from graspdsl.trials.record import TrialRecord
from graspdsl.trials.runner import execute
from graspdsl.trials.store import RunFolder
from graspdsl.trials.trajectories import CHANNELS, CONTACTS, TICK, packed

SPEC = Path(__file__).parents[2] / "specs" / "chapter" / "4_30_grasp_cartesian.yaml"
TRIALS = 4
WITHOUT_ENDS = "ALTER TABLE trials DROP COLUMN touching"
PARTS = ["manifest", "spec", "table", "origin", "rows", "trajectories", "packs", "state"]


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> RunFolder:
    """A finished run; not to be changed."""
    return stored_run(tmp_path_factory.mktemp("made") / "run", SPEC, f"trials.count={TRIALS}")


@pytest.fixture
def run(made: RunFolder, tmp_path: Path) -> RunFolder:
    """A run to be damaged."""
    shutil.copytree(made.path, tmp_path / "run")
    return RunFolder.at(tmp_path / "run")


def _faults(run: RunFolder) -> dict[str, tuple[int, ...]]:
    """The parts that are wrong, with the trials that are."""
    found = examined(run).findings
    return {finding.part: finding.trials for finding in found if finding.verdict is Verdict.FAULT}


def _notes(run: RunFolder) -> dict[str, str]:
    return {found.part: found.says for found in examined(run).findings if found.verdict is Verdict.NOTE}


def _alter(run: RunFolder, *statements: str) -> None:
    with closing(sqlite3.connect(run.path / "trials.sqlite")) as table, table:
        for statement in statements:
            table.execute(statement)


def _untimed(records: list[TrialRecord]) -> list[dict[str, object]]:
    return [{**record.as_dict(), "wall_s": 0.0} for record in records]


def _is_as_made(run: RunFolder, made: RunFolder) -> None:
    """The same trials with the same trajectories, in folders that are sound and hold nothing else."""
    assert (_faults(run), _notes(run)) == ({}, {})
    assert str(_untimed(run.records())) == str(_untimed(made.records()))
    assert [run.packs.content(piece) for piece in sorted(run.pieces())] == [
        made.packs.content(piece) for piece in sorted(made.pieces())
    ]
    sizes = [sum(pack.stat().st_size for pack in folder.packs.all()) for folder in (run, made)]
    assert sizes[0] == sizes[1]
    names = [{file.relative_to(folder.path) for file in folder.path.rglob("*")} for folder in (run, made)]
    assert names[0] == names[1]


def test_a_whole_run_is_told_part_by_part_and_left_as_it_is(made: RunFolder) -> None:
    found = examined(made)
    assert found.sound
    assert [(finding.part, finding.verdict) for finding in found.findings] == [(part, Verdict.WHOLE) for part in PARTS]
    assert found.findings[-1].says == f"complete: {TRIALS} of {TRIALS}"
    assert mended(made) == []


def _reach_over(run: RunFolder) -> None:
    """Let a trial's place be that of the next."""
    _alter(run, "UPDATE trajectories SET offset = (SELECT offset FROM trajectories WHERE number = 2) WHERE number = 1")


def _shorten(run: RunFolder) -> None:
    """Keep of a trial a whole trajectory of a program with fewer contacts."""
    of_contacts = {name for name, channel in CHANNELS.items() if channel.axes[:1] == (CONTACTS,)}
    rows = {name: values for name, values in run.trajectory(1).items() if name != TICK}
    piece = run.packs.put(1, packed({n: values[:, :2] if n in of_contacts else values for n, values in rows.items()}))
    _alter(run, f"REPLACE INTO trajectories VALUES ({', '.join(map(str, piece))})")


MENDED: dict[str, tuple[Callable[[RunFolder], object], dict[str, tuple[int, ...]]]] = {
    "a bit of a trajectory": (lambda run: lose_trajectory(run, 1), {"trajectories": (1,)}),
    "a place that is another's": (_reach_over, {"trajectories": (1,)}),
    "a place that is none": (
        lambda run: _alter(run, "UPDATE trajectories SET size = -3 WHERE number = 1"),
        {"trajectories": (1,)},
    ),
    "a trajectory of another program": (_shorten, {"trajectories": (1,)}),
    "no place": (lambda run: _alter(run, "DELETE FROM trajectories WHERE number = 2"), {"trajectories": (2,)}),
    "no pack": (lambda run: run.packs.file(0).unlink(), {"trajectories": (0, 1, 2, 3)}),
    "a pack cut": (lambda run: os.truncate(run.packs.file(0), 5), {"trajectories": (0, 1, 2, 3)}),
    "a row unreadable": (lambda run: _alter(run, "UPDATE trials SET start = 'x' WHERE number = 1"), {"rows": (1,)}),
    "a trial too many": (lambda run: _alter(run, "UPDATE trials SET number = 9 WHERE number = 1"), {"rows": (9,)}),
    "a row without a number": (
        lambda run: _alter(run, "UPDATE trials SET number = NULL WHERE number = 1"),
        {"rows": ()},
    ),
    "a row less": (lambda run: _alter(run, "DELETE FROM trials WHERE number = 1"), {}),
    "bytes of a trial that was never committed": (lambda run: run.packs.put(1, b"never committed"), {}),
    "a pack of nothing": (lambda run: run.packs.put(1000, b"never committed"), {}),
    "drafts": (lambda run: [(run.path / name).touch() for name in ("run.json.7.new", "trajectories/0.npz")], {}),
    "a mending that was killed": (
        lambda run: [run.packs.put(1, b"of nothing"), run.packs.file(1).with_suffix(".gz.new").touch()],
        {},
    ),
}


@pytest.mark.slow
@pytest.mark.parametrize("damage", MENDED)
def test_what_is_damaged_is_said_and_mended(damage: str, run: RunFolder, made: RunFolder) -> None:
    damaged_by, faults = MENDED[damage]
    damaged_by(run)
    before = {file: file.read_bytes() for file in run.path.rglob("*") if file.is_file()}
    assert _faults(run) == faults
    assert _faults(run) or _notes(run)
    assert {file: file.read_bytes() for file in run.path.rglob("*") if file.is_file()} == before
    mended(run)
    assert {*_faults(run)} <= {"trajectories"}  # those that resuming makes
    assert _notes(run) == {}
    execute(RunFolder.open(run.path), workers=1)
    mended(run)  # of what a trial was run again the first trajectory is none's
    _is_as_made(run, made)


@pytest.mark.parametrize(
    ("damage", "part"),
    [
        (lambda run: (run.path / "spec.yaml").write_text("graspdsl: one"), "spec"),
        (lambda run: (run.path / "spec.yaml").unlink(), "spec"),
        (lambda run: (run.path / "trials.sqlite").unlink(), "table"),
        (lambda run: (run.path / "trials.sqlite").write_text("no database"), "table"),
        (
            lambda run: (run.path / "trials.sqlite").write_bytes((run.path / "trials.sqlite").read_bytes()[:9000]),
            "table",
        ),
        (lambda run: _alter(run, "ALTER TABLE trials DROP COLUMN ticks"), "table"),
        (lambda run: _alter(run, "UPDATE trials SET identity = 'x'"), "origin"),
    ],
    ids=["spec faulty", "no spec", "no table", "table is text", "table cut", "other columns", "of another spec"],
)
def test_what_cannot_be_mended_is_said_and_left(
    damage: Callable[[RunFolder], object], part: str, run: RunFolder
) -> None:
    damage(run)
    before = {file: file.read_bytes() for file in run.path.rglob("*") if file.is_file()}
    assert {*_faults(run)} == {part}
    mended(run)
    assert {*_faults(run)} == {part}
    assert {file: file.read_bytes() for file in run.path.rglob("*") if file.is_file()} == before


@pytest.mark.parametrize(
    "change",
    [
        lambda run: _written(run, "spec.yaml", "γ3: point-3", "γ3: point-3, γ4: point-4"),
        lambda run: _written(run, "spec.yaml", "graspdsl: 1", "graspdsl: one"),
        lambda run: _written(run, "run.json", f'"asked": {TRIALS}', '"asked": 2'),
    ],
    ids=["another spec", "no spec", "fewer asked for"],
)
def test_nothing_is_taken_from_a_run_that_does_not_go_with_its_spec(
    change: Callable[[RunFolder], object], run: RunFolder
) -> None:
    """Not even what is damaged: all might look so."""
    lose_trajectory(run, 1)
    _alter(run, "UPDATE trials SET start = 'x' WHERE number = 0")
    run.packs.put(1, b"of nothing")
    change(run)
    run = RunFolder.at(run.path)
    before = {file: file.read_bytes() for file in run.path.rglob("*") if file.is_file()}
    assert {*_faults(run)} >= {"rows"}
    assert mended(run) == []
    assert {file: file.read_bytes() for file in run.path.rglob("*") if file.is_file()} == before


def _written(run: RunFolder, file: str, before: str, after: str) -> None:
    text = (run.path / file).read_text("utf-8")
    assert before in text
    (run.path / file).write_text(text.replace(before, after), "utf-8")


def test_a_manifest_that_cannot_be_read(run: RunFolder) -> None:
    (run.path / "run.json").write_text("{}")
    answer = CliRunner().invoke(app, ["doctor", str(run.path)])
    assert (answer.exit_code, answer.stdout) == (1, "")
    assert "error[not-a-run]" in answer.stderr


def test_a_run_that_is_being_run_is_told_as_it_is_and_not_mended(run: RunFolder) -> None:
    _alter(run, "DELETE FROM trials WHERE number = 3", "DELETE FROM trajectories WHERE number = 3")
    run.packs.put(3, b"what is being written right now")
    with locked(run.path):
        found = examined(run)
        assert (found.sound, found.findings[-1].says) == (True, f"running: 3 of {TRIALS}")
        with pytest.raises(DiagnosticError, match="another process is writing into this folder"):
            mended(run)


def _as_before(run: RunFolder) -> None:
    """Make a run what graspdsl 0.3.0 would have made of it: a file for each trajectory."""
    for piece in run.pieces():
        rows: dict[str, Any] = {name: values for name, values in run.unpacked(piece).items() if name != TICK}
        np.savez_compressed(run.packs.folder / f"{piece.number}.npz", **rows)
    run.packs.file(0).unlink()
    _alter(run, "DROP TABLE trajectories", "PRAGMA user_version = 0", WITHOUT_ENDS)


@pytest.mark.slow
@pytest.mark.parametrize("damaged", [(), (2,), (0, 1, 2, 3)], ids=str)
def test_a_run_of_an_earlier_version_becomes_one_of_this(
    damaged: tuple[int, ...], run: RunFolder, made: RunFolder
) -> None:
    """Also where this was tried before and stopped in the middle."""
    _as_before(run)
    for number in damaged:
        file = run.packs.folder / f"{number}.npz"
        file.write_bytes(file.read_bytes()[:-200])
    with pytest.raises(DiagnosticError, match="differs in its layout") as refusal:
        RunFolder.open(run.path)
    assert refusal.value.diagnostics[0].hint == f"make it one of this version: graspdsl doctor {run.path} --repair"
    assert _faults(run) == {"table": ()}
    run.packs.put(0, b"what a migration that was killed has left")
    done = mended(run)
    of_damaged = f"; damaged, to be run again: {len(damaged)}" if damaged else ""
    assert done[0] == f"trials of an earlier version: {TRIALS - len(damaged)}{of_damaged}"
    assert _faults(run) == ({"trajectories": damaged} if damaged else {})
    execute(RunFolder.open(run.path), workers=1)
    mended(run)
    if not damaged:
        _is_as_made(run, made)


def test_trials_that_do_not_tell_which_contacts_touched_are_told_it(run: RunFolder, made: RunFolder) -> None:
    assert [record.touching for record in run.records()] == [(True,) * 3] * TRIALS
    _alter(run, WITHOUT_ENDS)
    assert _faults(run) == {"table": ()}
    assert mended(run) == [f"trials of an earlier version: {TRIALS}"]
    _is_as_made(run, made)


def test_the_command(run: RunFolder, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("COLUMNS", "150")
    lose_trajectory(run, 1)
    answer = CliRunner().invoke(app, ["doctor", "run"])
    assert (answer.exit_code, answer.stderr) == (1, "")
    assert "1 damaged; the first: its checksum is not that of what was written (trial 1)" in answer.stdout
    answer = CliRunner().invoke(app, ["doctor", "run", "--repair", "--json"])
    document = json.loads(answer.stdout)
    assert (answer.exit_code, document["sound"], answer.stderr) == (1, False, "")
    assert document["mended"][0] == "rows removed: 0; trajectories removed: 1"
    assert [found["trials"] for found in document["findings"] if found["verdict"] == "fault"] == [[1]]
    execute(RunFolder.open(run.path), workers=1)
    assert CliRunner().invoke(app, ["doctor", "run"]).exit_code == 0
    for name in ("missing", "."):
        assert CliRunner().invoke(app, ["doctor", name]).exit_code == 1
