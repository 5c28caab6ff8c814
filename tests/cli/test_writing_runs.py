"""Runs whose folder fails them: a full disk, a folder that goes away, another process that writes into it."""

from __future__ import annotations

import json
import resource
import shutil
import subprocess
from collections.abc import Callable
from pathlib import Path

import pytest
from typer.testing import CliRunner

from cli.program import ROOT, begun, graspdsl, interrupt, numbers, stopped
from graspdsl.cli.app import app
from graspdsl.trials.folders import locked
from graspdsl.trials.store import RunFolder

pytestmark = pytest.mark.slow

FLOATING = ROOT / "specs" / "chapter" / "4_30_grasp_cartesian.yaml"
COUNT = "40"
GO_ON = "hint: finished trials are kept. Once that is mended, to go on: graspdsl run --resume run\n"


def _room(size: int) -> Callable[[], None]:
    """In a child about to begin: no file can be larger than this, as on a disk that is nearly full."""
    return lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (size, size))


def _out_of_room(size: int, place: Path, *words: str | Path) -> tuple[int | None, str]:
    with begun(*words, "--workers", "2", cwd=place, first=_room(size)) as run:
        _, messages = run.communicate(timeout=60)
    return run.returncode, messages


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> list[dict[str, object]]:
    """The numbers of the run that finds room for all."""
    words = ("run", FLOATING, "--trials", COUNT, "--out", "whole", "--json", "--no-report")
    return numbers(json.loads(graspdsl(*words, cwd=tmp_path_factory.mktemp("whole")).stdout))


@pytest.mark.parametrize("size", [25_000, 45_000, 150_000], ids=["no trial", "few trials", "more trials"])
def test_a_full_disk(size: int, whole: list[dict[str, object]], tmp_path: Path) -> None:
    code, messages = _out_of_room(size, tmp_path, "run", FLOATING, "--trials", COUNT, "--out", "run")
    assert code == 1
    assert messages.count("run: error[folder-not-writable]: cannot write to this folder: ") == 1
    assert messages.count("error[") == 1
    assert messages.endswith(GO_ON)
    assert not list(tmp_path.rglob("*.new"))
    folder = RunFolder.open(tmp_path / "run")
    assert len(folder.finished()) == len(folder.records()) < int(COUNT)
    resumed = graspdsl("run", "--resume", "run", "--json", "--no-report", cwd=tmp_path)
    assert resumed.returncode == 0, resumed.stderr
    assert numbers(json.loads(resumed.stdout)) == whole


@pytest.mark.parametrize("size", [100, 5_000], ids=["no spec", "no table"])
def test_a_run_that_cannot_be_begun_leaves_nothing(size: int, tmp_path: Path) -> None:
    code, messages = _out_of_room(size, tmp_path, "run", FLOATING, "--out", "run")
    assert code == 1
    assert messages.startswith("run: error[folder-not-writable]: cannot write to this folder: ")
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    ("lose", "complaint"),
    [
        (shutil.rmtree, "error[folder-gone]: this folder was removed or moved while its trials were run\n"),
        (lambda run: run.rename(run.with_name("moved")), "error[folder-gone]: this folder was removed or moved"),
        (
            lambda run: (run / "trials.sqlite").unlink(),
            "error[run-damaged]: this run is damaged: its trials.sqlite cannot be read: there is no such file\n",
        ),
    ],
    ids=["removed", "moved", "table removed"],
)
def test_a_folder_that_goes_away(lose: Callable[[Path], object], complaint: str, tmp_path: Path) -> None:
    def stop(_: subprocess.Popen[str]) -> None:
        lose(tmp_path / "run")

    words = ("run", FLOATING, "--trials", "500", "--workers", "2", "--out", "run")
    answer = stopped(*words, cwd=tmp_path, after=" 50/500 ", stop=stop)
    assert (answer.returncode, answer.stdout) == (1, "")
    assert f"run: {complaint}" in answer.stderr
    assert "kept. " not in answer.stderr
    assert ("begin a new run" in answer.stderr, "Traceback" in answer.stderr) == (True, False)
    if (tmp_path / "moved").exists():
        assert len(RunFolder.open(tmp_path / "moved").finished()) >= 50
    assert (tmp_path / "run").exists() == ("run-damaged" in complaint)


def test_a_second_process_is_refused(tmp_path: Path) -> None:
    """While one runs a run's trials, others read it and do not run them."""
    commands: list[tuple[str | Path, ...]] = [("run", "--resume", "run"), ("run", FLOATING, "--out", "run")]
    commands.append(("report", "run"))
    answers: list[subprocess.CompletedProcess[str]] = []

    def ask(process: subprocess.Popen[str]) -> None:
        answers.extend(graspdsl(*words, cwd=tmp_path) for words in commands)
        interrupt(process)

    words = ("run", FLOATING, "--trials", "5000", "--workers", "1", "--out", "run")
    assert stopped(*words, cwd=tmp_path, after="5000 trials", stop=ask).returncode == 130
    resumed, again, reported = answers
    assert resumed.returncode == 1
    assert resumed.stderr.startswith(
        "run: error[folder-in-use]: another process is writing into this folder\n  hint: try again when it has ended\n"
    )
    assert (again.returncode, "error[folder-not-empty]" in again.stderr) == (1, True)
    assert reported.returncode == 0


def test_experiments_in_one_folder_are_refused_too(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    Path("all").mkdir()
    with locked(Path("all")):
        spec = ROOT / "specs" / "experiments" / "4_detergent_bottle.yaml"
        answer = CliRunner().invoke(app, ["experiments", str(spec), "--out", "all"])
    assert (answer.exit_code, answer.stderr.count("all: error[folder-in-use]")) == (1, 1)
    assert [file.name for file in Path("all").iterdir()] == ["lock"]
