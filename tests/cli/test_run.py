"""Runs: the same numbers whichever way, the documents they print, the folders they leave."""

from __future__ import annotations

import json
import re
import shlex
import shutil
import subprocess
from pathlib import Path
from typing import Literal

import pytest
from pydantic import BaseModel, ConfigDict

from cli.program import PROGRAM, SHORT, SPEC, TRIALS, FinishedRun, graspdsl, numbers
from graspdsl.trials.outcomes import OUTCOMES

pytestmark = pytest.mark.slow


class _Exact(BaseModel):
    model_config = ConfigDict(strict=True, allow_inf_nan=False)


class _Trials(_Exact):
    asked: int
    finished: int


class _Change(_Exact):
    start: float | None
    end: float | None


class _Residuals(_Exact):
    force: _Change
    moment: _Change


class _Orientations(_Exact):
    start: list[float | None]
    end: list[float | None]


class _Mode(_Exact):
    centre: float
    share: float
    interval: tuple[float, float]
    force_residual: float | None
    moment_residual: float | None


class _Ticks(_Exact):
    median: float | None
    p90: float | None


class _Report(_Exact):
    """The fields that ``run --json`` and ``report --json`` promise."""

    name: str
    run: str
    trials: _Trials
    outcomes: dict[Literal[tuple(OUTCOMES)], int]
    residuals: _Residuals
    orientation: _Orientations
    modes: list[_Mode]
    ticks_to_converge: _Ticks
    quality: dict[Literal["force-closure", "ferrari-canny", "lift", "shake"], float]
    wall_s: float
    world_s: float


def test_the_document_holds_what_it_promises(finished: FinishedRun) -> None:
    report = _Report.model_validate_json(json.dumps(finished.document, allow_nan=False))
    assert report.name == "towel-roll-two-contacts"
    assert (report.trials.asked, report.trials.finished) == (TRIALS, TRIALS)
    assert sum(report.outcomes.values()) == TRIALS
    assert len(report.orientation.start) == len(report.orientation.end) == TRIALS


def test_orientations_stand_by_trial_number(finished: FinishedRun) -> None:
    records = finished.document["records"]
    assert [record["number"] for record in records] == list(range(TRIALS))
    for when in ("start", "end"):
        assert finished.document["orientation"][when] == [record[f"orientation_{when}"] for record in records]


def test_report_prints_the_document_again(finished: FinishedRun) -> None:
    answer = graspdsl("report", "run", "--json", cwd=finished.folder.parent)
    assert (answer.returncode, answer.stderr) == (0, "report: run/report.html\n")
    assert json.loads(answer.stdout) == finished.document


def test_a_run_leaves_a_page_and_figures(finished: FinishedRun) -> None:
    page = (finished.folder / "report.html").read_text("utf-8")
    assert finished.document["command"] in page
    figures = {file.name for file in (finished.folder / "figures").iterdir()}
    assert {"funnel.svg", "funnel.png"} <= figures
    assert {Path(name).stem for name in figures if name.endswith(".svg")} == {
        Path(name).stem for name in figures if name.endswith(".png")
    }


def test_without_a_place_for_the_page_numbers_are_still_printed(finished: FinishedRun, tmp_path: Path) -> None:
    shutil.copytree(finished.folder, tmp_path / "run")
    shutil.rmtree(tmp_path / "run" / "figures")
    (tmp_path / "run" / "figures").write_text("a file where the folder should be", "utf-8")
    answer = graspdsl("report", "run", "--json", cwd=tmp_path)
    assert (answer.returncode, json.loads(answer.stdout)) == (0, finished.document)
    warning = "run: warning[folder-not-writable]: cannot write to this folder: file exists\n"
    assert answer.stderr == warning


def test_messages_of_a_run(finished: FinishedRun) -> None:
    first, *progress, last = finished.messages.splitlines()
    assert last == "report: run/report.html"
    assert first == "towel-roll-two-contacts: 3 trials, seed 2006 → run"
    assert [line.split()[1] for line in progress] == ["1/3", "2/3", "3/3"]


def test_numbers_do_not_depend_on_workers_or_on_how_many_trials_there_are(
    finished: FinishedRun, tmp_path: Path
) -> None:
    words = ("run", SPEC, "--trials", "5", "--workers", "2", "--out", tmp_path / "run", "--json", "--no-report")
    answer = graspdsl(*words, cwd=tmp_path)
    assert answer.returncode == 0
    assert "report:" not in answer.stderr
    assert not (tmp_path / "run" / "report.html").exists()
    assert numbers(json.loads(answer.stdout))[:TRIALS] == numbers(finished.document)


def test_another_seed_gives_other_numbers(finished: FinishedRun, tmp_path: Path) -> None:
    answer = graspdsl("run", SPEC, "--trials", "1", "--seed", "7", "--json", "--no-report", cwd=tmp_path)
    document = json.loads(answer.stdout)
    assert document["seed"] == 7
    assert document["records"][0]["start"] != finished.document["records"][0]["start"]


def test_the_command_that_repeats_a_run(tmp_path: Path) -> None:
    place = tmp_path / "it's [red] a place"
    settings = ("--set", "scene.friction=0.5", "--set", "trials.count=9", "--set", "evaluate=[]")
    first = graspdsl("run", SPEC, *settings, "--trials", "1", "--out", place, "--no-report", cwd=tmp_path)
    command = first.stdout.splitlines()[-1].strip()
    assert command.endswith(" --set scene.friction=0.5 --set 'evaluate=[]' --trials 1 --seed 2006")
    again = graspdsl(*shlex.split(command)[1:], "--json", "--no-report", cwd=tmp_path)
    before = graspdsl("report", place, "--json", cwd=tmp_path)
    assert numbers(json.loads(again.stdout)) == numbers(json.loads(before.stdout))


def test_the_summary_says_what_converged_means_and_where_the_run_is(finished: FinishedRun) -> None:
    answer = graspdsl("report", "run", cwd=finished.folder.parent, env={"COLUMNS": "80"})
    lines = answer.stdout.splitlines()
    assert lines[0] == "towel-roll-two-contacts, seed 2006"
    assert lines[2] == "That is of feasible starts only: 23 of 26 draws could not be taken up."
    assert lines[3] == "Converged: ‖ρ_f‖ < 0.1, ‖ρ_m‖ < 5 mm, forces ± 0.1 N, all touching, for 1 s."
    assert lines[-2:] == [
        "The run is in run; to repeat it:",
        "  graspdsl run run/spec.yaml --trials 3 --seed 2006",
    ]
    assert max(map(len, lines)) <= 80


def test_the_summary_says_why_no_start_was_feasible(tmp_path: Path) -> None:
    """And no grades are given to trials that never began."""
    settings = ("--set", "trials.start={height: -0.05}", "--set", "evaluate=[force-closure, lift]")
    ended = graspdsl("run", SPEC, "--trials", "2", *settings, "--out", "run", cwd=tmp_path)
    assert ended.returncode == 1
    reason = "finger-1 meets the object or the table with another link"
    assert f"error[no-trial-begins]: none of the first 2 trials could begin: {reason} (2)" in ended.stderr
    answer = graspdsl("report", "run", cwd=tmp_path, env={"COLUMNS": "120"})
    [row] = [line for line in answer.stdout.splitlines() if line.startswith("infeasible-start") and reason in line]
    assert row.split(maxsplit=1) == ["infeasible-start", f"the start is not feasible: {reason}"]
    assert "of 0 trials that settled in contact" in answer.stdout
    assert "How good the grasps are" not in answer.stdout


def test_modes_say_of_which_trials_they_are(finished: FinishedRun) -> None:
    answer = graspdsl("report", "run", cwd=finished.folder.parent)
    said = re.search(r"^of (\d+) trials? that settled in contact", answer.stdout, flags=re.M)
    assert said is not None
    touching = finished.document["in_contact"]["end"]
    ended = zip(finished.document["records"], touching, strict=True)
    assert int(said[1]) == sum(OUTCOMES[record["outcome"]].settled and touched for record, touched in ended)


def test_runs_begun_at_once_get_folders_of_their_own(tmp_path: Path) -> None:
    command = [PROGRAM, "run", SPEC, "--trials", "1", *SHORT, "--json", "--no-report"]
    runs = [subprocess.Popen(command, cwd=tmp_path, stdout=subprocess.PIPE, stderr=subprocess.PIPE) for _ in range(3)]
    documents = [json.loads(run.communicate(timeout=120)[0]) for run in runs]
    assert {document["run"] for document in documents} == {f"runs/towel-roll-two-contacts-00{n}" for n in (1, 2, 3)}
    assert all(numbers(document) == numbers(documents[0]) for document in documents)


@pytest.mark.parametrize(
    ("setting", "complaint"),
    [
        ('name="[red]<script>"', "error[bad-name]"),
        ("name='a b'", "error[bad-name]"),
        ("name=../up", "error[bad-name]"),
        ('name="\\e[31m"', "error[bad-character]"),
    ],
)
def test_names_that_could_do_harm(setting: str, complaint: str, tmp_path: Path) -> None:
    answer = graspdsl("run", SPEC, "--set", setting, cwd=tmp_path)
    assert answer.returncode == 1
    assert complaint in answer.stderr
    assert "\x1b" not in answer.stderr
    assert list(tmp_path.iterdir()) == []


def test_names_in_any_script_and_objects_with_any_name(tmp_path: Path) -> None:
    body = 'scene.object={sphere: {diameter: 0.1}, mass: 0.4, name: "[red]<script>"}'
    settings = ("--set", "name=αβγ-é", "--set", body, "--set", "program.1.limit=0.1")
    answer = graspdsl("run", SPEC, "--trials", "1", *settings, cwd=tmp_path)
    assert answer.returncode == 0
    assert answer.stdout.startswith("αβγ-é, seed 2006\n")
    assert (tmp_path / "runs" / "αβγ-é-001" / "run.json").exists()
    assert 'name: "[red]<script>"' in answer.stdout.splitlines()[-1]
