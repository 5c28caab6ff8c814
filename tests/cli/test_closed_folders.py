"""Folders that their reader may not write to: what is there can be read, what is finished is kept."""

from __future__ import annotations

import ctypes
import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

from cli.program import ROOT, begun, graspdsl, heed_interrupts, numbers
from graspdsl.trials.store import RunFolder

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(sys.platform != "linux", reason="root is bound by permissions only where it can give that up"),
]

FLOATING = ROOT / "specs" / "chapter" / "4_30_grasp_cartesian.yaml"
DROP_FROM_BOUNDING_SET, OVERRIDE, READ_SEARCH = 24, 1, 2  # of prctl; capabilities of root
REFUSED = "error[folder-not-writable]: cannot write to this folder: permission denied\n"


def _bound_by_permissions() -> None:
    """In a child about to begin: what its user may not write to it cannot, whoever that is."""
    heed_interrupts()
    if os.geteuid() == 0:
        for capability in (OVERRIDE, READ_SEARCH):
            ctypes.CDLL(None).prctl(DROP_FROM_BOUNDING_SET, capability, 0, 0, 0)


def _answer(*words: str | Path, cwd: Path) -> tuple[int, str, str]:
    with begun(*words, cwd=cwd, first=_bound_by_permissions) as run:
        out, messages = run.communicate(timeout=60)
    return run.returncode, out, messages


def _close(folder: Path, *, closed: bool = True) -> None:
    for path in (folder, *folder.rglob("*")):
        path.chmod(path.stat().st_mode & ~0o222 if closed else path.stat().st_mode | 0o200)


def test_no_run_can_be_made_in_it(tmp_path: Path) -> None:
    (tmp_path / "mine").mkdir(mode=0o500)
    told = _answer("run", FLOATING, "--trials", "2", "--out", "mine/run", cwd=tmp_path)
    assert told == (1, "", f"mine/run: {REFUSED}")
    assert list((tmp_path / "mine").iterdir()) == []


def test_a_run_that_is_closed_keeps_what_it_has_and_goes_on_once_it_is_opened(tmp_path: Path) -> None:
    """Closed in the middle, then killed in the middle and closed: it can be read, and is not gone on with."""
    words = ("run", FLOATING, "--trials", "300", "--workers", "1", "--no-report", "--out")
    with begun(*words, "run", cwd=tmp_path, first=_bound_by_permissions) as run:
        _until_some_are_kept(run)
        _close(tmp_path / "run")
        _, messages = run.communicate(timeout=60)
    assert (run.returncode, messages.count(f"run: {REFUSED}"), messages.count("error[")) == (1, 1, 1)
    assert messages.endswith("finished trials are kept. Once that is mended, to go on: graspdsl run --resume run\n")
    _close(tmp_path / "run", closed=False)
    kept = len(RunFolder.open(tmp_path / "run").finished())
    with begun("run", "--resume", "run", "--workers", "1", cwd=tmp_path) as run:
        _until_some_are_kept(run)
        run.kill()
    _close(tmp_path / "run")
    code, _, messages = _answer("run", "--resume", "run", cwd=tmp_path)
    assert (code, messages.count(f"run: {REFUSED}"), "Traceback" in messages) == (1, 1, False)
    code, out, messages = _answer("report", "run", "--json", cwd=tmp_path)
    assert (code, messages) == (0, f"run: {REFUSED.replace('error', 'warning')}")
    assert 0 < kept < json.loads(out)["trials"]["finished"] < 300
    _close(tmp_path / "run", closed=False)
    resumed = graspdsl("run", "--resume", "run", "--json", "--no-report", cwd=tmp_path)
    whole = graspdsl(*words, "whole", "--json", cwd=tmp_path)
    assert numbers(json.loads(resumed.stdout)) == numbers(json.loads(whole.stdout))


def _until_some_are_kept(run: subprocess.Popen[str]) -> None:
    """Until a trial more is told than when it began, which is the third line that it says."""
    assert run.stderr is not None
    for _ in range(3):
        assert run.stderr.readline()
