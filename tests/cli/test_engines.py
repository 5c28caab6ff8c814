"""A spec on several engines, time steps and solver efforts by one command."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from report.reader import untold
from typer.testing import CliRunner

from graspdsl.cli.app import app
from graspdsl.report.agreement import QUANTITIES

from .program import ROOT, SPEC, codes, graspdsl

WAYS = ["mujoco", *(f"mujoco, {way} {what}" for what in ("time step", "solver effort") for way in ("half", "double"))]
QUICK = ("--worlds", "mujoco", "--trials", "1", "--seed", "9", "--set", "program.1.limit=0.1", "--workers", "1")


def asked(*words: str | Path) -> tuple[int, str]:
    """What the command answers: its exit code, and what it says on stderr."""
    answer = CliRunner().invoke(app, ["engines", *map(str, words)])
    return answer.exit_code, answer.stderr


@pytest.mark.slow
def test_every_way_is_a_run_that_goes_on_and_is_held_against_its_measure(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    done = graspdsl("engines", SPEC, *QUICK, "--out", "all", "--json", cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    found = json.loads(done.stdout)
    assert [run["label"] for run in found["runs"]] == WAYS
    assert [(run["time_step"], run["finished"]) for run in found["runs"]] == [
        *((0.002, 1), (0.001, 1), (0.004, 1)),
        *[(0.002, 1)] * 2,
    ]
    assert [(pair["run"], pair["measure"]) for pair in found["against"]] == [(place, 0) for place in range(1, 5)]
    assert all(
        pair["outcome"]["pairs"] == 1 and set(pair["quantities"]) == set(QUANTITIES) for pair in found["against"]
    )
    numbers = json.loads((tmp_path / "all" / "engines.json").read_text("utf-8"))
    assert {**numbers, "folder": "all"} == found
    page = (tmp_path / "all" / "engines.html").read_text("utf-8")
    assert all((tmp_path / "all" / way.replace(", ", "-").replace(" ", "-") / "run.json").is_file() for way in WAYS)
    assert all(f"{way} against mujoco" in page for way in WAYS[1:])
    assert untold(page, numbers) == set()
    again = CliRunner().invoke(app, ["engines", str(SPEC), *QUICK, "--out", "all"])
    assert again.exit_code == 0, again.stderr
    assert again.stderr.count("1 finished before") == len(WAYS)
    assert "points agree" in again.stdout
    code, messages = asked(SPEC, *QUICK, "--set", "scene.friction=0.6", "--out", "all")
    assert (code, messages.count("error[run-differs]")) == (1, 1)


@pytest.mark.parametrize(
    ("spec", "words", "said"),
    [
        ("specs/compare/cstar.yaml", (), "cstar.yaml:7:10: error[no-engine]: the floating world has no physics"),
        (SPEC, ("--worlds", "bulet,mujoco"), "error[unknown-world]: there is no engine 'bulet'"),
        (SPEC, ("--worlds", "floating"), "error[no-engine]: the floating world has no physics"),
        (
            SPEC,
            ("--worlds", "mujoco", "--plain"),
            "error[one-engine]: there is nothing to hold the mujoco world against",
        ),
    ],
)
def test_what_cannot_be_held_against_anything(spec: Path, words: tuple[str, ...], said: str, tmp_path: Path) -> None:
    code, messages = asked(ROOT / spec, *words, "--out", tmp_path / "x")
    assert (code, messages.count("error[")) == (1, 1)
    assert said in messages
    assert not (tmp_path / "x").exists()


@pytest.mark.slow
def test_a_cluster_may_share_the_trials(tmp_path: Path) -> None:
    pytest.importorskip("distributed")
    dask = ("--engine", "dask", "--scheduler", tmp_path / "none.json")
    code, messages = asked(SPEC, "--trials", "1", *dask, "--out", tmp_path / "x")
    assert (code, messages.count("error[no-scheduler]")) == (1, 1)


def test_a_refusal_is_one_json_document(tmp_path: Path) -> None:
    assert codes(graspdsl("engines", SPEC, "--worlds", "floating", "--json", cwd=tmp_path)) == ["no-engine"]
