"""Sweeps on the command line: begun, told, gone on with, read point by point; refused where none can be."""

from __future__ import annotations

import json
import shlex
from pathlib import Path

import pytest

from cli.program import SHORT, SPEC, graspdsl

pytestmark = pytest.mark.slow

SWEPT = ("--set", "scene.friction=0.3,0.8", "--trials", "2", *SHORT)


@pytest.fixture(scope="module")
def place(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with a finished sweep in it, called swept."""
    place = tmp_path_factory.mktemp("sweep")
    done = graspdsl("run", SPEC, *SWEPT, "--out", "swept", "--workers", "2", cwd=place)
    assert done.returncode == 0, done.stderr
    assert "Differences with friction, all else the same" in done.stdout
    assert "trials converged at 2 points" in " ".join(done.stdout.split())
    assert "4 trials, seed 2006, at 2 points → swept" in done.stderr
    assert (place / "swept" / "report.html").is_file()
    return place


def test_a_finished_sweep_is_told_as_a_document(place: Path) -> None:
    done = graspdsl("run", "--resume", "swept", "--json", "--no-report", cwd=place)
    said = json.loads(done.stdout)
    assert [point["values"] for point in said["points"]] == [{"scene.friction": 0.3}, {"scene.friction": 0.8}]
    assert [point["finished"] for point in said["points"]] == [2, 2]
    assert json.loads(graspdsl("report", "swept", "--json", cwd=place).stdout) == said


def test_the_command_of_a_sweep_repeats_it(place: Path) -> None:
    said = json.loads(graspdsl("report", "swept", "--json", cwd=place).stdout)
    words = shlex.split(said["command"])[1:]
    again = json.loads(graspdsl(*words, "--json", "--out", "again", "--no-report", cwd=place).stdout)
    assert [point["medians"] for point in again["points"]] == [point["medians"] for point in said["points"]]


def test_a_point_is_a_run_to_all_that_reads_one(place: Path) -> None:
    point = "swept/points/001"
    assert json.loads(graspdsl("report", point, "--json", cwd=place).stdout)["trials"]["finished"] == 2
    assert (place / point / "report.html").is_file()
    assert graspdsl("export", point, cwd=place).stdout.count("\n") == 3
    assert graspdsl("view", point, "--trial", "1", "--images", "seen", cwd=place).returncode == 0
    compared = graspdsl("compare", "swept/points/000", point, "--json", "--out", "compared", cwd=place)
    assert [run["settings"][-1] for run in json.loads(compared.stdout)["runs"]] == [
        "scene.friction=0.3",
        "scene.friction=0.8",
    ]
    differing = graspdsl("diff", "swept/points/000", point, cwd=place).stdout
    assert differing.split()[-4:] == ["spec", "scene.friction", "0.3", "0.8"]


@pytest.mark.parametrize(
    ("words", "code"),
    [
        (("view", "swept", "--trial", "0", "--images", "x"), "is-a-sweep"),
        (("compare", "swept", "swept/points/000"), "is-a-sweep"),
        (("map", SPEC, "--over", "roll,height", "--set", "scene.friction=0.3,0.8"), "is-a-sweep"),
        (("engines", SPEC, "--set", "scene.friction=0.3,0.8"), "is-a-sweep"),
        (("run", "--resume", "swept/points/001"), "part-of-a-sweep"),
        (("doctor", "swept/points/001", "--repair"), "part-of-a-sweep"),
        (("rm", "swept/points/001", "--yes"), "part-of-a-sweep"),
        (("report", "swept/points/002"), "folder-not-found"),
        (("run", SPEC, "--set", "scene.friction=0.3,-1"), "out-of-range"),
        (("run", SPEC, "--set", "scene.friction=0.3,0.4", "--trials", "60000"), "out-of-range"),
    ],
    ids=lambda each: each if isinstance(each, str) else " ".join(map(str, each[:2])),
)
def test_what_a_sweep_is_not_is_refused_in_one_line(place: Path, words: tuple[str, ...], code: str) -> None:
    done = graspdsl(*words, cwd=place)
    assert done.returncode == 1
    assert f"error[{code}]" in done.stderr
    assert done.stderr.count("error[") == 1
    assert "Traceback" not in done.stderr


def test_a_sweep_goes_as_a_whole(place: Path) -> None:
    graspdsl("run", SPEC, *SWEPT, "--out", "passing", "--no-report", cwd=place)
    graspdsl("report", "passing", cwd=place)
    graspdsl("report", "passing/points/000", cwd=place)
    assert graspdsl("rm", "passing", "--yes", cwd=place).returncode == 0
    assert not (place / "passing").exists()
