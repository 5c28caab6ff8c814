"""The runs in a folder, at a glance: what is counted is what is there, whatever is done to it meanwhile."""

from __future__ import annotations

import json
import shutil
import sqlite3
from collections.abc import Callable
from contextlib import closing
from pathlib import Path

import pytest
from stored_runs import stored_run
from typer.testing import CliRunner

from graspdsl.cli.app import app
from graspdsl.diagnostics import DiagnosticError
from graspdsl.report.run_list import ListedRun, State, listed_runs, size_said
from graspdsl.report.statistics import wilson
from graspdsl.trials import store
from graspdsl.trials.folders import locked
from graspdsl.trials.store import RunFolder

SPEC = Path(__file__).parents[2] / "specs" / "chapter" / "4_30_grasp_cartesian.yaml"
TRIALS = 3


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A finished run; not to be changed."""
    return stored_run(tmp_path_factory.mktemp("made") / "run", SPEC, f"trials.count={TRIALS}").path


@pytest.fixture
def run(made: Path, tmp_path: Path) -> Path:
    """A run in a folder of runs, to be changed."""
    shutil.copytree(made, tmp_path / "runs" / "a")
    return tmp_path / "runs" / "a"


def _only(runs: Path) -> ListedRun:
    [found] = listed_runs(runs)
    return found


def _alter(run: Path, statement: str) -> None:
    with closing(sqlite3.connect(run / "trials.sqlite")) as table, table:
        table.execute(statement)


def test_a_finished_run(run: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Which no record is read of."""
    monkeypatch.setattr(store, "record_of", None)
    found = _only(run.parent)
    assert (found.name, found.spec, found.seed, found.state) == ("a", "grasp-cartesian", 2006, State.COMPLETE)
    assert (found.finished, found.asked, found.converged) == (TRIALS, TRIALS, TRIALS)
    assert (found.share, found.interval) == (1.0, wilson(TRIALS, TRIALS))
    assert found.bytes == sum(file.stat().st_size for file in run.rglob("*") if file.is_file())
    assert found.begun is not None
    assert listed_runs(run)[0].name == "a"


def test_while_it_runs_and_after(run: Path) -> None:
    _alter(run, "DELETE FROM trials WHERE number = 1")
    with locked(run):
        assert (_only(run.parent).state, _only(run.parent).finished) == (State.RUNNING, TRIALS - 1)
    assert _only(run.parent).state is State.UNFINISHED


def test_while_another_writes(run: Path) -> None:
    """What is committed is counted at once, and what is not is not."""
    folder = RunFolder.open(run)
    with folder.held(), closing(sqlite3.connect(run / "trials.sqlite", isolation_level=None)) as writer:
        writer.execute("PRAGMA journal_mode = WAL")
        writer.execute("BEGIN IMMEDIATE")
        writer.execute("DELETE FROM trials")
        assert (_only(run.parent).state, _only(run.parent).finished) == (State.RUNNING, TRIALS)
        writer.execute("COMMIT")
        assert (_only(run.parent).finished, _only(run.parent).share) == (0, None)


@pytest.mark.parametrize(
    ("change", "state"),
    [
        (lambda run: (run / "run.json").write_text("{}"), State.DAMAGED),
        (lambda run: (run / "trials.sqlite").unlink(), State.DAMAGED),
        (lambda run: (run / "trials.sqlite").write_text("no database"), State.DAMAGED),
        (lambda run: (run / "spec.yaml").unlink(), State.DAMAGED),
        (lambda run: _alter(run, "INSERT INTO trials (number, outcome) VALUES (9, 'x')"), State.DAMAGED),
        (lambda run: _alter(run, "PRAGMA user_version = 0"), State.OUTDATED),
    ],
    ids=["manifest", "no table", "table is text", "no spec", "more trials than asked", "layout"],
)
def test_what_is_no_whole_run_is_listed_as_such(change: Callable[[Path], object], state: State, run: Path) -> None:
    change(run)
    assert _only(run.parent).state is state


def test_runs_within_folders_by_when_they_were_begun(run: Path) -> None:
    for name in ("several/x", "too/deep/y", "b"):
        shutil.copytree(run, run.parent / name)
    (run.parent / "note").touch()
    (run.parent / "several" / "x" / "spec.yaml").touch()
    assert [found.name for found in listed_runs(run.parent)] == ["a", "b", "several/x"]


@pytest.mark.parametrize(("place", "code"), [("missing", "folder-not-found"), ("file", "folder-not-readable")])
def test_no_folder(place: str, code: str, tmp_path: Path) -> None:
    (tmp_path / "file").touch()
    with pytest.raises(DiagnosticError) as refusal:
        listed_runs(tmp_path / place)
    assert [fault.code for fault in refusal.value.diagnostics] == [code]


def test_the_command(run: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("COLUMNS", "150")
    _alter(run, "DELETE FROM trials WHERE number = 1")
    shown = CliRunner().invoke(app, ["runs"])
    assert (shown.exit_code, shown.stderr) == (0, "")
    assert shown.stdout.splitlines()[-1].split()[:1] == ["a"]
    assert "2 of 3" in shown.stdout
    document = json.loads(CliRunner().invoke(app, ["runs", "--json"]).stdout)
    [listed] = document["runs"]
    assert (document["folder"], listed["state"], listed["converged"]) == ("runs", "unfinished", 2)
    assert CliRunner().invoke(app, ["runs", "missing"]).exit_code == 1
    Path("empty").mkdir()
    answer = CliRunner().invoke(app, ["runs", "empty"])
    assert (answer.exit_code, answer.stdout, answer.stderr) == (0, "", "there are no runs in empty\n")


def test_sizes_in_words() -> None:
    assert [size_said(size) for size in (0, 999, 1500, 2.5e6, 3e9)] == ["0 B", "999 B", "1.5 kB", "2.5 MB", "3.0 GB"]
