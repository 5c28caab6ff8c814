"""The folder of a run: what goes in comes out, two runs never share one, damage is said."""

from __future__ import annotations

import dataclasses
import math
import sqlite3
import threading
from contextlib import closing
from pathlib import Path

import numpy as np
import pytest
from stored_runs import lose_trajectory

from graspdsl.diagnostics import DiagnosticError
from graspdsl.trials.folders import fresh_folder
from graspdsl.trials.outcomes import OUTCOMES
from graspdsl.trials.priorities import CAUSES, Disturbance, Largest
from graspdsl.trials.record import Balance, RejectedStart, Trial, TrialRecord
from graspdsl.trials.store import Manifest, RunFolder
from trials.whole import whole_rows

MANIFEST = Manifest("a-run", "spec.yaml", ("scene.friction=0.5", "about=γ"), 2**63 - 1, 3, {"numpy": "2"})
NOTHING = (0.0,) * 6
RECORD = TrialRecord(
    number=2,
    identity="0123456789abcdef",
    outcome=OUTCOMES["palm-collision"],
    detail="the palm touched γ",
    start={"roll": 0.1 + 0.2, "height": 1e-300},
    rejected=(RejectedStart({"roll": 1 / 3, "height": 5e-324}, "a finger meets γ"), RejectedStart({}, "")),
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
    point_error=(math.nan, math.nan),
    normal_error=(0.1, 0.2),
    world_s=20.0,
    wall_s=0.7,
    balance=Balance((1 / 3, 5e-324, -0.0, 0.1, 0.2, 0.3), NOTHING, NOTHING, NOTHING),
    priorities=(
        Disturbance(0, "φ_fr", 8, Largest(1 / 3, 3, 0.06, CAUSES[0]), Largest(0.1 + 0.2, 4, 0.08, CAUSES[4])),
        Disturbance(1, "φ_f", 9, Largest(0.0, 0, 0.0, CAUSES[1]), Largest(5e-324, 9, 0.2, CAUSES[5]), 1500.0),
    ),
    quality={
        "force-closure": {"closed": True, "margin": {"value": 1 / 3, "reason": ""}, "reason": ""},
        "lift": {"kept": False, "reason": "no contacts", "borne": {"value": None, "reason": "no contacts"}},
    },
)
TRIAL = Trial(RECORD, {**whole_rows(4), "points": np.ones((4, 3, 3), dtype=np.float32)})
PACK = "trajectories/000000-000999.npy.gz"


@pytest.fixture
def folder(tmp_path: Path) -> RunFolder:
    """A new run with one trial."""
    made = RunFolder.create(tmp_path / "run", MANIFEST, "name: γ\n")
    made.add(TRIAL.packed())
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
    folder.add(dataclasses.replace(TRIAL, record=dataclasses.replace(RECORD, rejected=())).packed())
    assert [record.rejected for record in folder.records()] == [()]


def test_wall_time_adds_up(folder: RunFolder) -> None:
    folder.spend(1.5)
    folder.spend(2.0)
    assert RunFolder.open(folder.path).manifest.wall_s == 3.5


def test_what_was_left_half_written_is_removed(folder: RunFolder) -> None:
    drafts = [folder.path / "run.json.7.new", folder.path / "run.json.new"]
    for draft in drafts:
        draft.touch()
    before, packed = {file for file in folder.path.rglob("*") if file not in drafts}, (folder.path / PACK).read_bytes()
    folder.packs.put(1, b"of a trial that was never committed")
    folder.packs.put(1000, b"so is this")
    with folder.held():
        assert (folder.path / PACK).read_bytes() == packed
    other = folder.packs.file(1000)
    assert other.read_bytes() == b""
    assert {file for file in folder.path.rglob("*") if file not in {folder.path / "lock", other}} == before


def test_one_writes_to_a_run_at_a_time(folder: RunFolder) -> None:
    with folder.held(), folder.held():
        other = RunFolder.open(folder.path)
        with pytest.raises(DiagnosticError, match="another process is writing into this folder"), other.held():
            pass
        folder.add(TRIAL.packed())
    with other.held():
        other.add(TRIAL.packed())


def test_a_run_in_the_place_of_another_is_not_written_to(folder: RunFolder) -> None:
    with folder.held():
        folder.path.rename(folder.path.with_name("moved"))
        other = RunFolder.create(folder.path, MANIFEST, "")
        with other.held(), pytest.raises(DiagnosticError, match="this folder was removed or moved"):
            folder.add(TRIAL.packed())
    assert other.records() == []


def test_what_cannot_be_written_leaves_no_draft(folder: RunFolder) -> None:
    (folder.path / PACK).unlink()
    (folder.path / PACK).mkdir()
    with pytest.raises(DiagnosticError, match="cannot write to this folder: is a directory"):
        folder.add(TRIAL.packed())
    assert not list(folder.path.rglob("*.new"))


def test_a_trial_without_its_trajectory_is_not_finished(folder: RunFolder) -> None:
    assert len(folder.finished()) == 1
    file = folder.path / PACK
    file.write_bytes(file.read_bytes()[:-30])
    assert folder.finished() == []
    assert len(folder.records()) == 1


@pytest.mark.parametrize("content", [None, b"", b"\x1f\x8b cut", b"text" * 1000])
def test_unreadable_trajectory(folder: RunFolder, content: bytes | None) -> None:
    file = folder.path / PACK
    file.unlink() if content is None else file.write_bytes(content)
    with pytest.raises(DiagnosticError, match=f"this run is damaged: its {PACK} cannot be read: trial 2: "):
        folder.trajectory(2)


def test_trajectory_with_a_damaged_inside(folder: RunFolder) -> None:
    lose_trajectory(folder, 2)
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


def test_nothing_is_made_in_a_folder_that_holds_something(tmp_path: Path) -> None:
    (tmp_path / "mine.txt").touch()
    with pytest.raises(DiagnosticError, match="not empty"):
        RunFolder.create(tmp_path, MANIFEST, "graspdsl: 1\n")
    assert [path.name for path in tmp_path.iterdir()] == ["mine.txt"]


def test_a_file_in_the_way_is_left_alone(tmp_path: Path) -> None:
    (tmp_path / "run").write_text("mine")
    with pytest.raises(DiagnosticError, match="cannot write to this folder: file exists"):
        RunFolder.create(tmp_path / "run", MANIFEST, "")
    assert (tmp_path / "run").read_text() == "mine"


def _alter(folder: RunFolder, statement: str, *values: object) -> None:
    with closing(sqlite3.connect(folder.path / "trials.sqlite")) as table, table:
        table.execute(statement, values)


@pytest.mark.parametrize(
    ("column", "value", "reason"),
    [
        ("number", -1, "trial -1: number: input should be greater than or equal to 0"),
        ("number", 3, "trial 3: number: the run has 3 trials, from 0 on"),
        ("number", 2.0, "a row without the number of a trial: number: input should be a valid integer"),
        ("number", "2", "a row without the number of a trial: number: input should be a valid integer"),
        ("number", None, "a row without the number of a trial: number: input should be a valid integer"),
        ("identity", b"0123", "trial 2: identity: input should be a valid string"),
        ("outcome", "won", "trial 2: 'won' is not a valid Outcome"),
        ("outcome", 1, "trial 2: 1 is not a valid Outcome"),
        ("detail", None, "trial 2: detail: input should be a valid string"),
        ("start", "{", "trial 2: EOF while parsing an object"),
        ("start", None, "trial 2: a value has another type"),
        ("start", "[1]", "trial 2: start: input should be a valid dictionary"),
        ("start", '{"roll": "much"}', "trial 2: start.roll: input should be a valid number"),
        ("start", '{"roll": NaN}', "trial 2: expected value"),
        ("start", '{"roll": 1e400}', "trial 2: start.roll: input should be a finite number"),
        ("start", "[" * 100_000, "trial 2: recursion limit exceeded"),
        ("rejected", -1, "trial 2: rejected: input should be"),
        ("rejected", "{}", "trial 2: rejected: input should be a valid"),
        (
            "rejected",
            '[{"drawn": {"roll": "x"}, "reason": ""}]',
            "trial 2: rejected.0.drawn.roll: input should be a valid number",
        ),
        ("rejected", '[{"drawn": {"roll": 1e300}, "reason": ""}]', "trial 2: a value is too large to be measured"),
        ("ticks", 1.5, "trial 2: ticks: input should be a valid integer"),
        ("ticks_to_converge", "9", "trial 2: ticks_to_converge: input should be a valid integer"),
        ("orientation_end", "steep", "trial 2: orientation_end: input should be a valid number"),
        ("orientation_end", 1.6, "trial 2: an orientation is not between 0 and π/2"),
        ("orientation_start", -0.1, "trial 2: an orientation is not between 0 and π/2"),
        ("object_shift", -1e300, "trial 2: a value is too large to be measured"),
        ("world_s", None, "trial 2: world_s: input should be a valid number"),
        ("world_s", math.inf, "trial 2: world_s: input should be a finite number"),
        ("contact_forces", "{}", "trial 2: a value has another type"),
        ("contact_forces", "7", "trial 2: a value has another type"),
        ("contact_forces", '["x"]', "trial 2: contact_forces.0: input should be a valid number"),
        ("balance", "[]", "trial 2: balance: input should be"),
        ("balance", '{"contacts": [1]}', "trial 2: balance.contacts.1: field required"),
        ("balance", '{"contacts": [1, 2, 3, 4, 5, 1e400]}', "trial 2: balance.contacts.5: input should be a finite"),
        ("point_error", "[1, 2, 3]", "trial 2: point_error"),
        ("quality", '{"lift": {}}', "trial 2: quality.lift.kept: field required"),
        ("quality", '{"shake": true}', "trial 2: quality.shake: input should be a valid dictionary"),
        ("quality", '{"ferrari-canny": {"epsilon": 1}}', "trial 2: quality.ferrari-canny.epsilon"),
        ("quality", '{"mine": {"much": 1e400}}', "trial 2: a grade is infinite"),
        ("quality", f'{{"mine": {{"much": 1{"0" * 400}}}}}', "trial 2: a value is too large"),
    ],
)
def test_rows_that_no_trial_has(column: str, value: object, reason: str, folder: RunFolder) -> None:
    _alter(folder, f"UPDATE trials SET {column} = ?", value)
    code, message = _refusal(folder.path)
    assert code == "run-damaged"
    assert message.startswith(f"this run is damaged: its trials.sqlite cannot be read: {reason}")


@pytest.mark.parametrize("statement", ["ALTER TABLE trials RENAME TO others", "DROP TABLE trials"])
def test_a_table_without_trials(statement: str, folder: RunFolder) -> None:
    _alter(folder, statement)
    message = "this run is damaged: its trials.sqlite cannot be read: there is no table of trials in it"
    assert _refusal(folder.path) == ("run-damaged", message)


@pytest.mark.parametrize("cut", [0, 1, 2000, -1])
def test_a_table_that_was_cut_off_or_overwritten(cut: int, folder: RunFolder) -> None:
    file = folder.path / "trials.sqlite"
    content = file.read_bytes()
    file.write_bytes(bytes(len(content)) if cut < 0 else content[:cut])
    assert _refusal(folder.path)[0] == "run-damaged"


def test_a_table_of_another_version(folder: RunFolder) -> None:
    """Its columns are others: nothing is damaged."""
    with closing(sqlite3.connect(folder.path / "trials.sqlite")) as table, table:
        [made_by] = table.execute("SELECT sql FROM sqlite_master WHERE name = 'trials'").fetchone()
        table.execute("DROP TABLE trials")
        table.execute(made_by.replace(", tare_s", ", age"))
    message = "this run was made by another version of graspdsl, whose trials.sqlite differs in age and tare_s"
    assert _refusal(folder.path) == ("run-differs", message)


@pytest.mark.slow
def test_a_table_that_another_program_holds(folder: RunFolder) -> None:
    with closing(sqlite3.connect(folder.path / "trials.sqlite")) as table:
        table.execute("BEGIN EXCLUSIVE")
        assert _refusal(folder.path) == ("run-in-use", "another program holds this run's trials.sqlite")


@pytest.mark.parametrize("name", ["run.json", "trials.sqlite"])
def test_folders_in_place_of_files(name: str, folder: RunFolder) -> None:
    (folder.path / name).unlink()
    (folder.path / name).mkdir()
    assert _refusal(folder.path)[0] in {"not-a-run", "run-damaged"}


@pytest.mark.parametrize(
    ("before", "after"),
    [
        ('"asked": 3', '"asked": 0'),
        ('"asked": 3', '"asked": -1'),
        ('"asked": 3', '"asked": 1000000000000'),
        ('"asked": 3', '"asked": true'),
        ('"asked": 3', '"asked": "3"'),
        ('"asked": 3', '"asked": 3.5'),
        ('"asked": 3', '"asked": NaN'),
        (f'"seed": {2**63 - 1}', f'"seed": {2**63}'),
        (f'"seed": {2**63 - 1}', '"seed": -1'),
        ('"wall_s": 0.0', '"wall_s": NaN'),
        ('"wall_s": 0.0', '"wall_s": Infinity'),
        ('"wall_s": 0.0', '"wall_s": 1e400'),
        ('"wall_s": 0.0', '"wall_s": -1.0'),
        ('"numpy": "2"', '"numpy": 2'),
        ('"a-run"', '"\\ud800"'),
        ('"a-run"', f'"{"x" * 2**21}"'),
    ],
)
def test_manifests_that_no_run_has(before: str, after: str, folder: RunFolder) -> None:
    file = folder.path / "run.json"
    text = file.read_text("utf-8")
    assert before in text
    file.write_text(text.replace(before, after), "utf-8")
    assert _refusal(folder.path)[0] == "not-a-run"


def test_names_that_are_no_text_are_refused_before_anything_is_made(tmp_path: Path) -> None:
    with pytest.raises(DiagnosticError, match="is not UTF-8 text"):
        RunFolder.create(tmp_path / "run", dataclasses.replace(MANIFEST, spec_file="\udcff.yaml"), "")
    assert list(tmp_path.iterdir()) == []
