"""A run is removed, whole, and nothing with it that is not of it."""

from __future__ import annotations

import os
import pty
import subprocess
from pathlib import Path

import pytest
from cli.warm import PROGRAM
from stored_runs import stored_run
from typer.testing import CliRunner

import graspdsl as g
from graspdsl.cli.app import app
from graspdsl.trials.folders import locked

SPEC = Path(__file__).parents[2] / "specs" / "chapter" / "4_30_grasp_cartesian.yaml"


@pytest.fixture
def run(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A finished run, called run, in the working directory."""
    monkeypatch.chdir(tmp_path)
    return stored_run(Path("run"), SPEC, "trials.count=2").path


def _rm(*words: str) -> tuple[int, str, str]:
    answer = CliRunner().invoke(app, ["rm", *words])
    return answer.exit_code, answer.stdout, answer.stderr


@pytest.mark.slow
def test_all_of_it_goes(run: Path) -> None:
    g.open_run(run).report()
    for name in ("run.json.7.new", "trials.sqlite-wal", "trajectories/3.npz", "figures/x.png.7.new", "map.svg"):
        (run / name).touch()
    (run / "files" / "absolute-paths").mkdir(parents=True)
    (run / "files" / "absolute-paths" / "part.obj").touch()
    assert _rm("run", "./run", "--yes") == (0, "removed: run\n", "")
    assert list(Path().iterdir()) == []


def test_what_is_not_of_the_run_stays(run: Path) -> None:
    Path("thesis").mkdir()
    Path("thesis/chapter").touch()
    (run / "files").symlink_to(Path("thesis").absolute())
    (run / "trajectories" / "note").touch()
    code, said, told = _rm("run", "--yes")
    assert (code, said) == (0, "removed: run\n")
    assert told == "not of the run, and still there: run/files, run/trajectories, run/trajectories/note\n"
    assert Path("thesis/chapter").exists()


def test_nothing_is_removed_where_one_is_no_run_or_is_run(run: Path) -> None:
    before = sorted(run.rglob("*"))
    Path("other").mkdir()
    Path("other/note").touch()
    assert _rm("run", "other", "--yes")[::2] == (
        1,
        "other: error[not-a-run]: this is no run: there is no readable run.json in it\n"
        "  hint: give the folder that 'graspdsl run' made\n",
    )
    assert "missing: error[folder-not-found]" in _rm("missing", "run", "--yes")[2]
    with locked(run):
        assert _rm("run", "--yes")[2].startswith("run: error[folder-in-use]: another process is writing into this")
    assert (sorted(run.rglob("*")), Path("other/note").exists()) == (before, True)


def test_without_a_terminal_it_is_not_asked_and_not_done(run: Path) -> None:
    code, _, told = _rm("run")
    assert (code, "there is nobody to ask: give --yes" in told, run.exists()) == (2, True, True)


@pytest.mark.slow
@pytest.mark.parametrize(("answer", "is_left"), [(b"n\n", True), (b"\n", True), (b"y\n", False)])
def test_at_a_terminal_it_is_asked(answer: bytes, is_left: bool, run: Path) -> None:
    ours, theirs = pty.openpty()
    with subprocess.Popen([PROGRAM, "rm", "run"], stdin=theirs, stdout=subprocess.PIPE, stderr=theirs) as process:
        os.close(theirs)
        os.write(ours, answer)
        process.communicate(timeout=60)
    told = os.read(ours, 4096).decode()
    os.close(ours)
    assert (process.returncode, run.exists()) == (0, is_left)
    assert "run: grasp-cartesian, seed 2006, 2 of 2 trials, " in told
    assert "Remove what it holds? [y/N]" in told
