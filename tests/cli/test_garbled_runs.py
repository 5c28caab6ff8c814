"""Runs whose files were garbled byte by byte: each is reported or refused, with no crash and no number that is none."""

from __future__ import annotations

import json
import random
import shutil
from collections.abc import Iterator
from pathlib import Path

import pytest
from typer.testing import CliRunner

from cli.program import ROOT
from graspdsl.cli.app import app
from graspdsl.cli.running import opened
from graspdsl.compiler.program import program_of
from graspdsl.diagnostics import DiagnosticError
from graspdsl.report.comparison import comparison
from graspdsl.report.evidence import evidence_of
from graspdsl.report.summary import plain, summarised
from graspdsl.trials.runner import execute, new_run
from graspdsl.trials.store import RunFolder

pytestmark = pytest.mark.slow

SPEC = ROOT / "specs" / "compare" / "moment_subject_to_force.yaml"
FILES = ("run.json", "spec.yaml", "trials.sqlite", "trajectories/000000-000999.npy.gz")
GARBLED, SHOWN = 250, 6


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> RunFolder:
    """Two trials of floating contacts."""
    text, overrides = SPEC.read_text("utf-8"), ("trials.count=2",)
    program = program_of(text, SPEC.name, overrides)
    folder = new_run(tmp_path_factory.mktemp("runs") / "whole", program)
    execute(folder, 1)
    return folder


def garbled(whole: RunFolder, place: Path, chance: random.Random) -> Path:
    """A copy of a run, one of its files with bits turned, bytes replaced or moved, or its end cut off."""
    shutil.rmtree(place, ignore_errors=True)
    shutil.copytree(whole.path, place)
    file = place / chance.choice(FILES)
    content = bytearray(file.read_bytes())
    start, end = sorted(chance.randrange(len(content)) for _ in range(2))
    match chance.choice(["turn", "write", "blank", "move", "cut"]):
        case "turn":
            content[start] ^= 1 << chance.randrange(8)
        case "write":
            content[start] = chance.choice(b'0123456789-e.:{}[]", \n\x1b')
        case "blank":
            content[start : start + 60] = bytes(len(content[start : start + 60]))
        case "move":
            content = content[:start] + content[end:] + content[start:end]
        case "cut":
            del content[start:]
    file.write_bytes(content)
    return place


def each(whole: RunFolder, place: Path, count: int, seed: int) -> Iterator[Path]:
    """So many garbled copies, one after the other."""
    chance = random.Random(seed)
    for _ in range(count):
        yield garbled(whole, place, chance)


def test_every_garbled_run_is_read_or_refused(whole: RunFolder, tmp_path: Path) -> None:
    refused = 0
    for place in each(whole, tmp_path / "run", GARBLED, seed=4):
        try:
            opened_run = opened(place)
            evidence = opened_run.evidence
            runs = [(run, summarised(run)) for run in (evidence_of(whole), evidence)]
            json.dumps(plain([runs[1][1], comparison(runs)]), allow_nan=False)
            lost = {record.number for record in evidence.records} - evidence.courses.keys()
            assert lost == {0, 1} - {record.number for record in opened_run.folder.finished()}
        except DiagnosticError:
            refused += 1
    assert GARBLED / 4 < refused < GARBLED


def test_the_commands_show_garbled_runs_or_complain_once(
    whole: RunFolder, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Each fault once, and several only of a spec, all faults of which are told."""
    monkeypatch.chdir(tmp_path)
    for number, _ in enumerate(each(whole, tmp_path / "run", SHOWN, seed=5)):
        for words in (
            ["report", "run"],
            ["compare", str(whole.path), "run", "--out", f"compared-{number}"],
            ["view", "run", "--images", "seen", "--frames", "1"],
            ["run", "--resume", "run", "--workers", "1"],
        ):
            answer = CliRunner().invoke(app, words)
            errors = [line for line in answer.stderr.splitlines() if "error[" in line]
            assert (answer.exit_code, bool(errors)) in {(0, False), (1, True)}, answer.output
            assert len(set(errors)) == len(errors)
            assert len(errors) <= 1 or all(line.startswith("run/spec.yaml:") for line in errors), answer.output
            assert "Traceback" not in answer.output
            assert "\x1b" not in answer.output
