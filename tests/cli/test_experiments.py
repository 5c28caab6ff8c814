"""The chapter's experiments by one command."""

from __future__ import annotations

import json
from pathlib import Path

from .program import ROOT, graspdsl

SPEC = ROOT / "specs" / "experiments" / "4_detergent_bottle.yaml"
QUICK = ("--set", "evaluate=[]", "--set", "scene.mount=gantry", "--trials", "2", "--seed", "9", "--workers", "1")


def test_claims_and_pages(tmp_path: Path) -> None:
    done = graspdsl("experiments", str(SPEC), *QUICK, "--out", str(tmp_path / "all"), "--json", cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    claims = json.loads(done.stdout)["claims"]
    assert {claim["experiment"] for claim in claims} == {"experiment-4"}
    assert json.loads((tmp_path / "all" / "conformance.json").read_text("utf-8")) == claims
    page = (tmp_path / "all" / "report.html").read_text("utf-8")
    assert all(claim["says"] in page for claim in claims)
    assert "experiment-4/report.html" in page
    assert claims[0]["says"] in (tmp_path / "all" / "experiment-4" / "report.html").read_text("utf-8")
    again = graspdsl("experiments", str(SPEC), *QUICK, "--out", str(tmp_path / "all"), cwd=tmp_path)
    assert again.returncode == 0, again.stderr
    assert "2 finished before" in again.stderr
    assert "points agree" in again.stdout
    other = graspdsl("experiments", str(SPEC), *QUICK, "--seed", "8", "--out", str(tmp_path / "all"), cwd=tmp_path)
    assert other.returncode == 1
    assert "other settings" in other.stderr


def test_a_spec_without_claims_is_refused(tmp_path: Path) -> None:
    done = graspdsl(
        "experiments", str(ROOT / "specs" / "towel_roll_two_contacts.yaml"), "--out", str(tmp_path / "x"), cwd=tmp_path
    )
    assert done.returncode == 1
    assert "no claims about" in done.stderr
    assert not (tmp_path / "x").exists()
