"""Runs that are stopped: one message, what was finished is kept, and the resumed run gives the same numbers."""

from __future__ import annotations

import json
import os
import random
import signal
import subprocess
import sys
import time
from contextlib import suppress
from pathlib import Path

import pytest

from cli.program import ROOT, TRIALS, Stop, begun, graspdsl, numbers, stopped
from graspdsl.report.evidence import evidence_of
from graspdsl.report.summary import plain, summarised
from graspdsl.trials.store import RunFolder

pytestmark = pytest.mark.slow

RESUME = "finished trials are kept. To go on:\n  graspdsl run --resume 'the run'\n"
CLOSE = ROOT / "specs" / "chapter" / "close.yaml"  # whose trials are short
# Where contacts are probed, trials run one after the other: the second has just begun when the first is finished.
QUICK = ("--set", "scene.world=mujoco", "--set", "control.displacement=probing")
FLOATING = ROOT / "specs" / "chapter" / "4_30_grasp_cartesian.yaml"


@pytest.fixture(scope="module")
def undisturbed(tmp_path_factory: pytest.TempPathFactory) -> list[dict[str, object]]:
    """The numbers of a run that nothing stops."""
    words = ("run", CLOSE, *QUICK, "--trials", str(TRIALS), "--workers", "1", "--json", "--no-report")
    answer = graspdsl(*words, cwd=tmp_path_factory.mktemp("undisturbed"))
    return numbers(json.loads(answer.stdout))


def _to_all(number: signal.Signals) -> Stop:
    """As a terminal does it."""
    return lambda run: os.killpg(run.pid, number)


def _to_parent(number: signal.Signals) -> Stop:
    return lambda run: run.send_signal(number)


def _workers(run: subprocess.Popen[str]) -> list[int]:
    listing = subprocess.run(
        ["ps", "-A", "-ww", "-o", "ppid=,pid=,args="], capture_output=True, encoding="utf-8", check=True
    )
    rows = [line.split(maxsplit=2) for line in listing.stdout.splitlines()]
    return [int(pid) for parent, pid, command in rows if int(parent) == run.pid and "spawn_main" in command]


def _to_a_worker(number: signal.Signals) -> Stop:
    return lambda run: os.kill(_workers(run)[0], number)


def _stopped(place: Path, workers: int, stop: Stop) -> tuple[int, str, str]:
    """Exit code, stdout and stderr of a run that is stopped when its first trial is finished."""
    words = ("run", CLOSE, *QUICK, "--trials", str(TRIALS), "--workers", str(workers), "--out", "the run", "--json")
    answer = stopped(*words, "--no-report", cwd=place, after=f" 1/{TRIALS} ", stop=stop)
    return answer.returncode, answer.stdout, answer.stderr


def _resumed(place: Path) -> list[dict[str, object]]:
    answer = graspdsl("run", "--resume", "the run", "--json", "--no-report", cwd=place)
    assert answer.returncode == 0
    return numbers(json.loads(answer.stdout))


@pytest.mark.parametrize(
    ("stop", "workers"),
    [
        (_to_all(signal.SIGINT), 1),
        (_to_all(signal.SIGINT), 2),
        (_to_parent(signal.SIGINT), 2),
        (_to_parent(signal.SIGTERM), 1),
    ],
    ids=["Ctrl-C, one process", "Ctrl-C, two workers", "SIGINT to the parent of two", "SIGTERM, one process"],
)
def test_interrupted(stop: Stop, workers: int, undisturbed: list[dict[str, object]], tmp_path: Path) -> None:
    code, out, messages = _stopped(tmp_path, workers, stop)
    assert (code, out) == (130, "")
    assert messages.endswith(f"interrupted; {RESUME}")
    assert "Traceback" not in messages
    report = plain(summarised(evidence_of(RunFolder.open(tmp_path / "the run"))))
    kept = numbers(report)
    assert 1 <= report["trials"]["finished"] == len(kept) < TRIALS
    assert all(record in undisturbed for record in kept)
    assert _resumed(tmp_path) == undisturbed


PATTERNS = {
    "SIGTERM": (signal.SIGTERM, 1, _to_parent),
    "SIGTERM to all": (signal.SIGTERM, 1, _to_all),
    "SIGHUP to all": (signal.SIGHUP, 1, _to_all),
    "Ctrl-C": (signal.SIGINT, 1, _to_all),
    "SIGINT": (signal.SIGINT, 1, _to_parent),
    "SIGINT twice": (signal.SIGINT, 2, _to_parent),
    "Ctrl-C five times": (signal.SIGINT, 5, _to_all),
}


@pytest.mark.parametrize("workers", [1, 2])
@pytest.mark.parametrize("pattern", PATTERNS)
def test_signals_at_any_moment(pattern: str, workers: int, tmp_path: Path) -> None:
    """From its start-up on, a large run ends soon, says once what is kept, and keeps it whole."""
    number, times, to = PATTERNS[pattern]
    moment = random.Random(f"{pattern}, {workers}").uniform(0.3, 4.0)
    words = ("run", FLOATING, "--trials", "20000", "--workers", str(workers), "--out", "the run")
    with begun(*words, cwd=tmp_path) as run:
        time.sleep(moment)
        asked = time.monotonic()
        for _ in range(times):
            with suppress(ProcessLookupError):
                to(number)(run)
            time.sleep(0.3 / times)
        out, messages = run.communicate(timeout=60)  # which waits for its workers, who hold the other end of stderr
        took = time.monotonic() - asked
    assert (run.returncode, out, messages.count("interrupted")) == (130, "", 1)
    assert took < 3.0
    assert not list(tmp_path.rglob("*.new"))
    if list(tmp_path.iterdir()):
        assert messages.endswith(f"interrupted; {RESUME}")
        folder = RunFolder.open(tmp_path / "the run")
        assert len(folder.finished()) == len(folder.records())
    else:
        assert messages.endswith("interrupted; there was nothing to keep: give the command again\n")


def test_what_is_said_is_said_where_a_simulator_is_silenced(tmp_path: Path) -> None:
    code = (
        "import os, signal\n"
        "from graspdsl.trials.interruption import interruption\n"
        "from graspdsl.worlds.bullet.engine import silenced\n"
        "interruption.heed(130, b'the end')\n"
        "with silenced():\n"
        "    os.kill(os.getpid(), signal.SIGTERM)\n"
    )
    done = subprocess.run([sys.executable, "-c", code], cwd=tmp_path, capture_output=True, check=False)
    assert (done.returncode, done.stdout, done.stderr) == (130, b"", b"the end")


@pytest.mark.parametrize("number", [signal.SIGKILL, signal.SIGSEGV])
def test_a_run_goes_on_without_a_worker(
    number: signal.Signals, undisturbed: list[dict[str, object]], tmp_path: Path
) -> None:
    code, out, messages = _stopped(tmp_path, 2, _to_a_worker(number))
    assert code == 0
    assert numbers(json.loads(out)) == undisturbed
    assert "Traceback" not in messages


def test_a_run_that_is_killed_loses_no_finished_trial(tmp_path: Path) -> None:
    """Whatever write to its table or its packs it was at: killed again and again, it comes to the same end."""
    asked = ("run", FLOATING, "--trials", "400", "--workers", "2", "--no-report", "--out")
    chance, told = random.Random(7), 0
    for _ in range(4):
        going_on = (tmp_path / "the run" / "run.json").exists()
        words = ("run", "--resume", "the run", "--workers", "2", "--no-report") if going_on else (*asked, "the run")
        with begun(*words, cwd=tmp_path) as run:
            with suppress(subprocess.TimeoutExpired):
                run.communicate(timeout=chance.uniform(2.0, 4.5))
            run.kill()
        folder = RunFolder.open(tmp_path / "the run")
        assert len(folder.finished()) == len(folder.records()) >= told
        told = len(folder.records())
    whole = graspdsl(*asked, "whole", "--json", cwd=tmp_path)
    assert _resumed(tmp_path) == numbers(json.loads(whole.stdout))


def test_workers_do_not_outlive_a_killed_parent(tmp_path: Path) -> None:
    orphans: list[int] = []

    def kill(run: subprocess.Popen[str]) -> None:
        orphans.extend(_workers(run))
        run.kill()

    # The workers hold the other end of stderr: that it closes means that they are gone.
    code, _, _ = _stopped(tmp_path, 2, kill)
    assert code == -signal.SIGKILL
    assert len(orphans) == 2


@pytest.mark.parametrize("workers", [1, 2])
def test_a_bug_leaves_a_crash_log(workers: int, tmp_path: Path) -> None:
    """A broken installation of the simulator is a failure that nothing in the project expects."""
    broken = tmp_path / "broken"
    broken.mkdir()
    (broken / "pybullet.py").write_text("raise RuntimeError('this installation is broken')\n")
    logs = tmp_path / "logs"
    logs.mkdir()
    words = ("run", CLOSE, "--trials", "2", "--workers", str(workers), "--out", "the run", "--json")
    answer = graspdsl(*words, cwd=tmp_path, env={"PYTHONPATH": str(broken), "TMPDIR": str(logs)}, anew=True)
    (log,) = logs.iterdir()
    assert (answer.returncode, answer.stdout) == (3, "")
    assert answer.stderr.splitlines()[-2:] == [
        "graspdsl: a bug: RuntimeError: this installation is broken",
        f"  the crash log is {log}; please send it with the command you ran",
    ]
    assert "Traceback" not in answer.stderr
    text = log.read_text(encoding="utf-8")
    assert "RuntimeError: this installation is broken" in text
    assert "pybullet.py" in text
    assert "--trials" in text
    assert graspdsl("run", "--resume", "the run", "--no-report", cwd=tmp_path).returncode == 0
