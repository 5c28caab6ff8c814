"""Hand files to begin with, on the command line."""

from __future__ import annotations

from pathlib import Path

import pytest

from .program import ROOT, graspdsl

pytestmark = pytest.mark.slow

TRIO = ROOT / "graspdsl" / "hands" / "trio.urdf"


def test_from_a_model_to_trials(tmp_path: Path) -> None:
    """One command writes a hand, a spec and pictures; the spec runs as it is."""
    answer = graspdsl("init", "hand", TRIO, "--out", "mine.yaml", cwd=tmp_path)
    assert answer.returncode == 0, answer.stderr
    assert answer.stdout.split() == ["mine.yaml", "mine_grasp.yaml", "mine-open.png", "mine-closed.png"]
    assert "next: graspdsl run mine_grasp.yaml" in answer.stderr
    run = graspdsl("run", "mine_grasp.yaml", "--trials", "2", "--workers", "1", "--set", "evaluate=[]", cwd=tmp_path)
    assert run.returncode == 0, run.stderr
    assert "2 trials" in run.stdout or "of 2" in run.stdout
    again = graspdsl("init", "hand", TRIO, "--out", "mine.yaml", cwd=tmp_path)
    assert again.returncode == 1
    assert "file-exists" in again.stderr
