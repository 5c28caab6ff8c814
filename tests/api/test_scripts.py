"""Scripts as users write them: without a guard, from wherever Python takes them, with workers; and stopped."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
from cli.program import ROOT, heed_interrupts

import graspdsl as g

pytestmark = pytest.mark.slow

SPEC = ROOT / "specs" / "chapter" / "4_30_grasp_cartesian.yaml"
SCRIPT = f"""
import os, json
import graspdsl as g
with open("begun", "a") as file:
    file.write("once ")
run = g.run({str(SPEC)!r}, trials=4, seed=7, workers=2, progress=False)
print(json.dumps([trial.identity for trial in run.trials]))
"""
WAYS = {
    "a file": ([sys.executable, "script.py"], ""),
    "a module": ([sys.executable, "-m", "script"], ""),
    "stdin": ([sys.executable, "-"], SCRIPT),
    "the command line": ([sys.executable, "-c", SCRIPT], ""),
    "a prompt": ([sys.executable, "-i"], SCRIPT.replace("\nrun", "\n\nrun")),
}


@pytest.fixture(scope="module")
def alone() -> list[str]:
    """Of the trials of a script, run in one process, the identities."""
    return [trial.identity for trial in g.run(SPEC, trials=4, seed=7, workers=1, progress=False).trials]


@pytest.mark.parametrize("way", WAYS)
def test_a_script_needs_no_guard(way: str, alone: list[str], tmp_path: Path) -> None:
    """It is run once, in its own process alone, and its workers give the numbers that one process gives."""
    command, typed = WAYS[way]
    (tmp_path / "script.py").write_text(SCRIPT, "utf-8")
    done = subprocess.run(command, input=typed, cwd=tmp_path, capture_output=True, encoding="utf-8", check=False)
    assert done.returncode == 0, done.stderr
    assert (tmp_path / "begun").read_text("utf-8").split() == ["once"]
    assert json.loads(done.stdout.splitlines()[-1]) == alone


def test_there_were_two_workers(tmp_path: Path) -> None:
    """Whom the process of a script sees beside itself."""
    script = f"""
import multiprocessing
import graspdsl as g
crew = []
run = g.run({str(SPEC)!r}, trials=2, workers=2, progress=lambda _: crew.append(len(multiprocessing.active_children())))
print(crew[0])
import __main__
print(__main__.__file__)
"""
    (tmp_path / "script.py").write_text(script, "utf-8")
    done = subprocess.run(
        [sys.executable, "script.py"], cwd=tmp_path, capture_output=True, encoding="utf-8", check=True
    )
    assert done.stdout.split() == ["2", str(tmp_path / "script.py")]


@pytest.mark.parametrize("workers", [1, 2])
def test_ctrl_c_stops_a_script_and_keeps_its_trials(workers: int, tmp_path: Path) -> None:
    """The script may do as it likes with the exception; the library heeds no signal by itself."""
    spec = ROOT / "specs" / "towel_roll_two_contacts.yaml"
    script = f"""
import graspdsl as g
print("first", flush=True)
short = g.load({str(spec)!r}, set=["program.1.limit=1.0"])
g.run(short, trials=50, workers={workers}, out="run", progress=lambda record: print(record.number, flush=True))
"""
    (tmp_path / "script.py").write_text(script, "utf-8")
    with subprocess.Popen(
        [sys.executable, "script.py"],
        cwd=tmp_path,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        encoding="utf-8",
        start_new_session=True,
        preexec_fn=heed_interrupts,
    ) as process:
        assert process.stdout is not None
        assert process.stdout.readline() == "first\n"
        assert process.stdout.readline().strip().isdecimal()
        os.killpg(process.pid, signal.SIGINT)  # as a terminal has it: to the workers, too
        _, errors = process.communicate(timeout=60)
    assert process.returncode == -signal.SIGINT
    assert "KeyboardInterrupt" in errors
    assert "finished trials are kept; to go on: graspdsl.resume('run')" in errors
    kept = g.open_run(tmp_path / "run")
    assert 1 <= len(kept.trials) < 50
    assert all(len(kept.trajectory(trial.number)["time"]) > 0 for trial in kept.trials)
    assert not _left(process.pid)


def _left(session: int) -> list[str]:
    """The processes of a session that are still there a moment later."""
    time.sleep(1.0)
    listed = subprocess.run(["ps", "-eo", "sess=,pid=,args="], capture_output=True, encoding="utf-8", check=True)
    return [line for line in listed.stdout.splitlines() if line.split()[0] == str(session) and "<defunct>" not in line]
