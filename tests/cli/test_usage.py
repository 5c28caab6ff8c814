"""Wrong use: exit code 2, what is wrong on stderr, nothing on stdout."""

from __future__ import annotations

from pathlib import Path

import pytest
from typer.testing import CliRunner

from cli.program import SPEC, graspdsl
from graspdsl.cli.app import LARGEST_SEED, MOST_TRIALS, app
from graspdsl.spec.models import Spec

RESUMED = "a resumed run keeps its trials, seed, folder and settings"

EMPTY = "the name is empty"

WRONG_USE = [
    ((), "Usage: graspdsl"),
    (("bogus",), "No such command 'bogus'"),
    (("--bogus",), "No such option: --bogus"),
    (("validate",), "Missing argument"),
    (("explain",), "Missing argument"),
    (("report",), "Missing argument"),
    (("schema", "more"), "(more)"),
    (("run",), "give a spec, or --resume a run"),
    (("run", str(SPEC), "more"), "(more)"),
    (("run", str(SPEC), "--bogus"), "No such option: --bogus"),
    (("run", str(SPEC), "--trials", "0"), "'--trials'"),
    (("run", str(SPEC), "--trials", "-3"), "'--trials'"),
    (("run", str(SPEC), "--trials", "1e9"), "'--trials'"),
    (("run", str(SPEC), "--trials", "1000000000"), "'--trials'"),
    (("run", str(SPEC), "--trials", "abc"), "'--trials'"),
    (("run", str(SPEC), "--seed", "-1"), "'--seed'"),
    (("run", str(SPEC), "--seed", str(2**63)), "'--seed'"),
    (("run", str(SPEC), "--workers", "0"), "'--workers'"),
    (("run", str(SPEC), "--workers", "100000"), "'--workers'"),
    (("run", "--resume", "x", "--trials", "3"), RESUMED),
    (("run", "--resume", "x", "--seed", "3"), RESUMED),
    (("run", "--resume", "x", "--out", "y"), RESUMED),
    (("run", "--resume", "x", "--set", "scene.friction=0.5"), RESUMED),
    (("explain", "π_a", "--as", "prose"), "'--as'"),
    (("validate", ""), EMPTY),
    (("validate", str(SPEC), ""), EMPTY),
    (("run", ""), EMPTY),
    (("run", str(SPEC), "--out", ""), EMPTY),
    (("run", "--resume", ""), EMPTY),
    (("map", ""), EMPTY),
    (("map", str(SPEC), "--over", "roll,height", "--out", ""), EMPTY),
    (("map", "--resume", ""), EMPTY),
    (("report", ""), EMPTY),
    (("compare", "", "x"), EMPTY),
    (("compare", "x", "y", "--out", ""), EMPTY),
    (("experiments", ""), EMPTY),
    (("experiments", str(SPEC), "--out", ""), EMPTY),
]


@pytest.mark.parametrize(("words", "message"), WRONG_USE)
def test_wrong_use(words: tuple[str, ...], message: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    answer = CliRunner().invoke(app, words)
    assert answer.exit_code == 2
    assert message in answer.stderr
    assert answer.stdout == ""
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("words", [("bogus",), ("run", "x", "--trials", "abc"), ()])
def test_the_program_ends_with_the_same_code(words: tuple[str, ...], tmp_path: Path) -> None:
    answer = graspdsl(*words, cwd=tmp_path)
    assert (answer.returncode, answer.stdout) == (2, "")
    assert "Usage: graspdsl" in answer.stderr
    assert "Traceback" not in answer.stderr


def test_version(tmp_path: Path) -> None:
    answer = graspdsl("--version", cwd=tmp_path)
    assert (answer.returncode, answer.stdout, answer.stderr) == (0, "graspdsl 0.3.0\n", "")


@pytest.mark.parametrize("command", ["validate", "run", "explain", "report", "schema"])
def test_every_command_has_help(command: str) -> None:
    answer = CliRunner().invoke(app, [command, "-h"])
    assert (answer.exit_code, answer.stderr) == (0, "")
    assert f"{command}" in answer.stdout


def test_options_have_the_bounds_of_the_spec() -> None:
    trials = Spec.model_json_schema()["$defs"]["Trials"]["properties"]
    assert (trials["count"]["minimum"], trials["count"]["maximum"]) == (1, MOST_TRIALS)
    assert (trials["seed"]["minimum"], trials["seed"]["maximum"]) == (0, LARGEST_SEED)
