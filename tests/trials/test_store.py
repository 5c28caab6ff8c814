"""The folder of a run: what goes in comes out, two runs never share one, damage is said."""

from __future__ import annotations

import dataclasses
import math
import threading
from pathlib import Path

import numpy as np
import pytest

from graspdsl.diagnostics import DiagnosticError
from graspdsl.trials.outcomes import Outcome
from graspdsl.trials.record import Trial, TrialRecord
from graspdsl.trials.store import Manifest, RunFolder, fresh_folder
from trials.whole import whole_rows

MANIFEST = Manifest("a-run", "spec.yaml", ("scene.friction=0.5", "about=γ"), 2**63 - 1, 3, {"numpy": "2"})
RECORD = TrialRecord(
    number=2,
    identity="0123456789abcdef",
    outcome=Outcome.PALM_COLLISION,
    detail="the palm touched γ",
    start={"roll": 0.1 + 0.2, "height": 1e-300},
    redraws=3,
    orientation_start=math.nan,
    orientation_end=math.nextafter(1.0, 2.0),
    force_residual_start=math.inf,
    force_residual_end=5e-324,
    moment_residual_start=-0.0,
    moment_residual_end=1 / 3,
    contact_forces=(0.1, math.nan, 1 / 3),
    object_shift=0.0,
    object_lean=0.0,
    ticks=0,
    ticks_to_converge=None,
    samples=121,
    largest_leak=0.0,
    leaking_ticks=0,
    point_error=(math.nan, math.nan),
    normal_error=(0.1, 0.2),
    world_s=20.0,
    wall_s=0.7,
    quality={
        "force-closure": {"closed": True, "margin": 1 / 3, "reason": ""},
        "lift": {"kept": False, "reason": "no contacts"},
    },
)
TRIAL = Trial(RECORD, {**whole_rows(4), "points": np.ones((4, 3, 3), dtype=np.float32)})


@pytest.fixture
def folder(tmp_path: Path) -> RunFolder:
    """A new run with one trial."""
    made = RunFolder.create(tmp_path / "run", MANIFEST, "name: γ\n")
    made.add(TRIAL)
    return made


def _bits(record: TrialRecord) -> str:
    """A text that is the same only for the same bits; NaN equals NaN."""
    return repr(dataclasses.astuple(record))


def _refusal(path: Path) -> tuple[str, str]:
    with pytest.raises(DiagnosticError) as caught:
        RunFolder.open(path)
    (diagnostic,) = caught.value.diagnostics
    return diagnostic.code, diagnostic.message


def test_records_come_back_to_the_last_bit(folder: RunFolder) -> None:
    (record,) = RunFolder.open(folder.path).records()
    assert _bits(record) == _bits(RECORD)


def test_manifest_and_spec_come_back(folder: RunFolder) -> None:
    opened = RunFolder.open(folder.path)
    assert opened.manifest == MANIFEST
    assert opened.spec_text == "name: γ\n"


def test_trajectories_come_back(folder: RunFolder) -> None:
    arrays = RunFolder.open(folder.path).trajectory(2)
    assert arrays.keys() == TRIAL.trajectory.keys()
    assert all(np.array_equal(arrays[name], array) for name, array in TRIAL.trajectory.items())


def test_a_trial_may_be_added_again(folder: RunFolder) -> None:
    folder.add(dataclasses.replace(TRIAL, record=dataclasses.replace(RECORD, redraws=9)))
    assert [record.redraws for record in folder.records()] == [9]


def test_wall_time_adds_up(folder: RunFolder) -> None:
    folder.spend(1.5)
    folder.spend(2.0)
    assert RunFolder.open(folder.path).manifest.wall_s == 3.5


def test_a_trial_without_its_trajectory_is_not_finished(folder: RunFolder) -> None:
    assert len(folder.finished()) == 1
    file = folder.trajectory_file(2)
    file.write_bytes(file.read_bytes()[:-30])
    assert folder.finished() == []
    assert len(folder.records()) == 1


@pytest.mark.parametrize("content", [None, b"", b"PK\x03\x04 cut", b"text"])
def test_unreadable_trajectory(folder: RunFolder, content: bytes | None) -> None:
    file = folder.trajectory_file(2)
    file.unlink() if content is None else file.write_bytes(content)
    with pytest.raises(DiagnosticError, match=r"this run is damaged: its trajectories/2.npz cannot be read"):
        folder.trajectory(2)


def test_trajectory_with_a_damaged_inside(folder: RunFolder) -> None:
    file = folder.trajectory_file(2)
    content = bytearray(file.read_bytes())
    content[45:75] = bytes(30)
    file.write_bytes(content)
    with pytest.raises(DiagnosticError, match="this run is damaged"):
        folder.trajectory(2)


@pytest.mark.parametrize("text", ["", "[]", "null", '{"name": 1}', '{"name": "x"', "\x00"])
def test_unreadable_manifest(folder: RunFolder, text: str) -> None:
    (folder.path / "run.json").write_text(text)
    assert _refusal(folder.path) == ("not-a-run", "this is no run: there is no readable run.json in it")


def test_missing_table_is_not_made_anew(folder: RunFolder) -> None:
    (folder.path / "trials.sqlite").unlink()
    message = "this run is damaged: its trials.sqlite cannot be read: there is no such file"
    assert _refusal(folder.path) == ("run-damaged", message)
    assert not (folder.path / "trials.sqlite").exists()


def test_a_folder_is_given_to_one_run_only(tmp_path: Path) -> None:
    found: list[Path] = []
    threads = [
        threading.Thread(target=lambda: found.append(fresh_folder(tmp_path / "runs", "name"))) for _ in range(16)
    ]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert sorted(found) == [tmp_path / "runs" / f"name-{number:03d}" for number in range(1, 17)]


def test_free_numbers_are_used(tmp_path: Path) -> None:
    (tmp_path / "name-001").mkdir()
    (tmp_path / "name-002").touch()
    assert fresh_folder(tmp_path, "name") == tmp_path / "name-003"


def test_two_runs_cannot_be_made_in_one_folder(folder: RunFolder) -> None:
    with pytest.raises(DiagnosticError, match="this folder is not empty"):
        RunFolder.create(folder.path, MANIFEST, "")
    assert len(folder.records()) == 1


def test_a_file_in_the_way_is_left_alone(tmp_path: Path) -> None:
    (tmp_path / "run").write_text("mine")
    with pytest.raises(DiagnosticError, match="cannot write to this folder: file exists"):
        RunFolder.create(tmp_path / "run", MANIFEST, "")
    assert (tmp_path / "run").read_text() == "mine"
