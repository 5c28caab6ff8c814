"""Folders that are no runs, damaged runs, finished runs."""

from __future__ import annotations

import json
import shutil
import sqlite3
from contextlib import closing
from pathlib import Path

import numpy as np
import pytest
from rich.text import Text
from stored_runs import lose_trajectory
from typer.testing import CliRunner

from cli.program import SPEC, TRIALS, FinishedRun, codes, graspdsl, numbers
from graspdsl.cli.app import app
from graspdsl.cli.tables import laid_out, text_of
from graspdsl.report.tables import Column, Table
from graspdsl.trials.identity import identities
from graspdsl.trials.runner import program_of_run
from graspdsl.trials.store import RunFolder


@pytest.fixture
def copied(finished: FinishedRun, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A copy of a finished run, called run, in the working directory."""
    monkeypatch.chdir(tmp_path)
    shutil.copytree(finished.folder, tmp_path / "run")
    return tmp_path / "run"


@pytest.mark.parametrize(
    ("out", "complaint"),
    [
        (
            "full",
            "full: error[folder-not-empty]: this folder is not empty\n  hint: name another, or go on with --resume",
        ),
        ("file", "file: error[folder-not-writable]: cannot write to this folder: file exists"),
        ("file/run", "file/run: error[folder-not-writable]: cannot write to this folder: not a directory"),
    ],
)
def test_no_folder_for_a_run(out: str, complaint: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    Path("full").mkdir()
    Path("full/note").write_text("mine")
    Path("file").write_text("mine")
    answer = CliRunner().invoke(app, ["run", str(SPEC), "--trials", "1", "--out", out])
    assert (answer.exit_code, answer.stdout, answer.stderr) == (1, "", f"{complaint}\n")
    assert (Path("full/note").read_text(), Path("file").read_text()) == ("mine", "mine")


def test_no_default_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    Path("runs").touch()
    answer = CliRunner().invoke(app, ["run", str(SPEC), "--trials", "1"])
    assert answer.exit_code == 1
    assert answer.stderr == "runs: error[folder-not-writable]: cannot write to this folder: file exists\n"


@pytest.mark.parametrize("words", [("run", "--resume"), ("report",), ("doctor",)])
@pytest.mark.parametrize("folder", ["empty", "file"])
def test_no_run(words: tuple[str, ...], folder: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    Path("empty").mkdir()
    Path("file").touch()
    answer = CliRunner().invoke(app, [*words, folder, "--json"])
    assert answer.exit_code == 1
    assert f'"path": "{folder}"' in answer.stdout
    assert answer.stderr == (
        f"{folder}: error[not-a-run]: this is no run: there is no readable run.json in it\n"
        "  hint: give the folder that 'graspdsl run' made\n"
    )


@pytest.mark.parametrize(
    "words",
    [
        ("run", "--resume"),
        ("report",),
        ("compare", "runs"),
        ("view", "--images", "seen", "--trial", "0"),
        ("export",),
        ("doctor", "--repair"),
        ("rm", "--yes"),
    ],
)
@pytest.mark.parametrize("folder", ["missing", "missing/run"])
def test_no_folder(words: tuple[str, ...], folder: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    given = [folder if word == "runs" else word for word in words]
    answer = CliRunner().invoke(app, [*given, folder])
    assert (answer.exit_code, answer.stdout, answer.stderr) == (
        1,
        "",
        f"{folder}: error[folder-not-found]: there is no such folder\n"
        "  hint: give the folder that 'graspdsl run' made\n",
    )
    assert list(tmp_path.iterdir()) == []


def _alter(run: Path, statement: str) -> None:
    with closing(sqlite3.connect(run / "trials.sqlite")) as table, table:
        table.execute(statement)


def _cut(file: Path, size: int) -> None:
    file.write_bytes(file.read_bytes()[:size])


DAMAGES = {
    "manifest of other types": (lambda run: (run / "run.json").write_text('{"name": 3}'), "not-a-run"),
    "manifest cut": (lambda run: _cut(run / "run.json", 40), "not-a-run"),
    "no table": (lambda run: (run / "trials.sqlite").unlink(), "run-damaged"),
    "table cut": (lambda run: _cut(run / "trials.sqlite", 3000), "run-damaged"),
    "table is text": (lambda run: (run / "trials.sqlite").write_text("no database"), "run-damaged"),
    "table of other columns": (lambda run: _alter(run, "ALTER TABLE trials DROP COLUMN ticks"), "run-differs"),
    "row unreadable": (lambda run: _alter(run, "UPDATE trials SET start = 'x' WHERE number = 1"), "run-damaged"),
    "outcome unknown": (lambda run: _alter(run, "UPDATE trials SET outcome = 'x' WHERE number = 1"), "run-damaged"),
    "no spec": (lambda run: (run / "spec.yaml").unlink(), "run-damaged"),
    "spec faulty": (lambda run: (run / "spec.yaml").write_text("graspdsl: one"), "wrong-version"),
}


@pytest.mark.slow
@pytest.mark.parametrize("words", [("run", "--resume"), ("report",)])
@pytest.mark.parametrize("damage", DAMAGES)
def test_damaged_run(words: tuple[str, ...], damage: str, copied: Path) -> None:
    alter, code = DAMAGES[damage]
    alter(copied)
    answer = CliRunner().invoke(app, [*words, "run"])
    assert answer.exit_code == 1
    assert f"error[{code}]" in answer.stderr
    assert answer.stdout == ""


@pytest.mark.slow
@pytest.mark.parametrize("loss", ["row", "trajectory", "trajectory cut", "all trajectories"])
def test_what_is_lost_is_run_again(loss: str, copied: Path, finished: FinishedRun, tmp_path: Path) -> None:
    folder = RunFolder.open(copied)
    file, whole = folder.packs.file(1), folder.trajectory(1)
    if loss == "row":
        _alter(copied, "DELETE FROM trials WHERE number = 1")
    elif loss == "trajectory":
        lose_trajectory(folder, 1)
    elif loss == "trajectory cut":
        _cut(file, 1000)
    else:
        shutil.rmtree(file.parent)
    answer = CliRunner().invoke(app, ["run", "--resume", "run", "--json", "--no-report"])
    assert answer.exit_code == 0
    again = RunFolder.open(copied).trajectory(1)
    assert all(np.array_equal(again[name], rows, equal_nan=True) for name, rows in whole.items())
    assert [path.name for path in file.parent.iterdir()] == ["000000-000999.npy.gz"]
    report = graspdsl("report", "run", "--json", cwd=tmp_path)
    assert numbers(json.loads(answer.stdout)) == numbers(json.loads(report.stdout)) == numbers(finished.document)


@pytest.mark.slow
def test_a_complete_run_is_only_reported(copied: Path) -> None:
    before = (copied / "trials.sqlite").read_bytes()
    answer = CliRunner().invoke(app, ["run", str(SPEC), "--resume", "run", "--workers", "2"])
    assert answer.exit_code == 0
    assert (
        answer.stderr
        == "towel-roll-two-contacts: 3 trials, seed 2006, 3 finished before → run\nreport: run/report.html\n"
    )
    assert (copied / "trials.sqlite").read_bytes() == before


@pytest.mark.slow
def test_a_run_from_another_spec(copied: Path, tmp_path: Path) -> None:
    text = SPEC.read_text(encoding="utf-8").replace("friction: 0.4", "friction: 0.5")
    (tmp_path / "other.yaml").write_text(text, encoding="utf-8")
    answer = CliRunner().invoke(app, ["run", "other.yaml", "--resume", "run"])
    assert (answer.exit_code, answer.stderr) == (
        1,
        "other.yaml: error[run-differs]: this is not the spec that run was run from\n"
        "  hint: leave it out: --resume knows its own\n",
    )
    (copied / "spec.yaml").write_text(text, encoding="utf-8")
    for words in (("run", "--resume", "run"), ("report", "run"), ("view", "run", "--images", "seen")):
        _refused_as_another(words)
    (copied / "spec.yaml").write_text(SPEC.read_text("utf-8"), "utf-8")
    assert CliRunner().invoke(app, ["report", "run"]).exit_code == 0


def _refused_as_another(words: tuple[str, ...]) -> None:
    answer = CliRunner().invoke(app, list(words))
    assert (answer.exit_code, answer.stdout, answer.stderr) == (
        1,
        "",
        "run: error[run-differs]: this run was made from another spec, other files or another seed than it holds now\n"
        "  hint: put its own spec.yaml, run.json and files back, or begin a new run\n",
    )


def _edit(run: Path, **values: object) -> None:
    manifest = run / "run.json"
    manifest.write_text(json.dumps({**json.loads(manifest.read_text("utf-8")), **values}), "utf-8")


@pytest.mark.parametrize(
    "values", [{"seed": 7}, {"name": "another"}, {"asked": 4}, {"overrides": ["trials.count=3", "scene.friction=0.5"]}]
)
def test_a_manifest_that_was_changed(values: dict[str, object], copied: Path) -> None:
    _edit(copied, **values)
    _refused_as_another(("report", "run"))
    _refused_as_another(("compare", "run", "run"))


def test_trials_of_another_run(copied: Path) -> None:
    _alter(copied, "UPDATE trials SET identity = '0123456789abcdef' WHERE number = 1")
    _refused_as_another(("report", "run"))


@pytest.mark.slow
def test_a_run_of_other_versions_is_reported(copied: Path) -> None:
    """Libraries differ between machines; a spec may mean something else only to another graspdsl."""
    made_by = json.loads((copied / "run.json").read_text("utf-8"))["versions"]
    program = program_of_run(RunFolder.open(copied))
    elsewhere = {**made_by, "numpy": "1.26.0"}
    of = identities(program, program.spec.trials.seed, elsewhere)
    for number in range(TRIALS):
        _alter(copied, f"UPDATE trials SET identity = '{of(number)}' WHERE number = {number}")
    _edit(copied, versions=elsewhere)
    answer = CliRunner().invoke(app, ["report", "run"])
    assert (answer.exit_code, answer.stderr) == (0, "report: run/report.html\n")
    _edit(copied, versions={**elsewhere, "graspdsl": "0.0.1"})
    _alter(copied, "UPDATE trials SET identity = 'of another version'")
    answer = CliRunner().invoke(app, ["report", "run"])
    assert answer.exit_code == 0
    assert answer.stderr.startswith("run: warning[run-unchecked]: this run was made by graspdsl 0.0.1; whether from")


@pytest.mark.slow
def test_what_steers_a_terminal_is_shown_and_not_done(copied: Path) -> None:
    """A folder's name and a library's version may hold anything; neither reaches the terminal as it is."""
    named = copied.rename(copied.parent / "run\x1b[2J\x9b1A")
    _edit(named, versions={"graspdsl": "\x1b]0;title\x07"})
    for words in (("report", named.name), ("compare", named.name, named.name), ("report", named.name, "--json")):
        answer = CliRunner().invoke(app, [*words])
        assert answer.exit_code == 0
        assert "2J" in answer.stdout
        assert "title" in answer.stderr
        assert not set("\x1b\x9b\x07") & set(answer.stdout + answer.stderr)


def test_tables_show_text_only() -> None:
    side = laid_out(Table("a\x1b[2Jtitle", (Column("a\x1b[2Jcolumn"),), (("a\x1b[2Jcell",),), "a\x1b[2Jnote"))
    text = text_of(["a\x1b[2Jline", Text("a\x1b[2Jtext"), side], "a\x1b[2Jcommand")
    assert text.count("\ufffd[2J") == 7
    assert "\x1b" not in text


NO_TEXT = "x\udcff"  # how Python keeps the byte ff of a name


@pytest.mark.parametrize(
    "words",
    [
        ("run", NO_TEXT),
        ("run", str(SPEC), "--out", NO_TEXT),
        ("run", "--resume", NO_TEXT),
        ("report", NO_TEXT),
        ("compare", NO_TEXT, NO_TEXT),
        ("view", NO_TEXT, "--images", "seen"),
        ("validate", NO_TEXT),
    ],
)
def test_names_that_are_no_text(words: tuple[str, ...], tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    answer = CliRunner().invoke(app, [*words])
    complaint = "x\ufffd: error[not-utf8]: this name is not UTF-8 text\n  hint: give it another name\n"
    assert (answer.exit_code, answer.stdout, answer.stderr) == (1, "", complaint)
    assert list(tmp_path.iterdir()) == []


def test_the_program_refuses_names_that_are_no_text(tmp_path: Path) -> None:
    answer = graspdsl("run", SPEC, "--out", NO_TEXT, "--json", cwd=tmp_path)
    assert (answer.returncode, codes(answer)) == (1, ["not-utf8"])
    assert list(tmp_path.iterdir()) == []
