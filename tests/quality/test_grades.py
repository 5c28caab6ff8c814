"""A grade is one class and one entry of a table: asked for, checked, run, and told everywhere."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from graspdsl.cli.app import app
from graspdsl.contracts.grades import RULES
from graspdsl.quality import grades
from graspdsl.quality.grade import Found, Grade, Grasp, Quantity

SPEC = Path(__file__).parents[2] / "specs" / "chapter" / "4_18_grasp.yaml"


class SpreadGrade(Grade):
    """How far apart contacts are."""

    name = "spread-out"
    about = "whether the contacts lie far apart"
    definition = "Spread out: the contacts lie farther apart than a nut is wide."
    passed = "wide"
    column = "spread out"
    quantities = (Quantity("span", "span", "m", ".3f", ".1f"),)

    def of(self, grasp: Grasp) -> Found:
        """Wide or not, and the largest distance of two contacts."""
        if grasp.missing:
            return {"wide": False, "reason": grasp.missing, "span": {"value": None, "reason": grasp.missing}}
        span = float(np.linalg.norm(grasp.points[:, None] - grasp.points, axis=-1).max())
        reason = "" if span > 0.03 else "the contacts lie close together"
        return {"wide": not reason, "reason": reason, "span": {"value": span, "reason": ""}}


@pytest.fixture
def _added(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setitem(grades.GRADES, SpreadGrade.name, SpreadGrade())
    monkeypatch.chdir(tmp_path)


def said(*words: str) -> str:
    """What a command prints that does what it is asked."""
    answer = CliRunner().invoke(app, list(words))
    assert answer.exit_code == 0, answer.output
    return answer.stdout


@pytest.mark.usefixtures("_added")
def test_an_added_grade_keeps_the_contract() -> None:
    assert [said for rule in RULES.values() for said in rule(grades.GRADES["spread-out"])] == []


@pytest.mark.slow
@pytest.mark.usefixtures("_added")
def test_an_added_grade_is_listed_run_and_told() -> None:
    assert json.loads(said("list", "grades", "--json"))["grades"][-1] == {
        "name": "spread-out",
        "from": "graspdsl",
        "about": "whether the contacts lie far apart",
        "definition": "Spread out: the contacts lie farther apart than a nut is wide.",
    }
    assert "spread-out" in json.loads(said("schema"))["properties"]["evaluate"]["items"]["enum"]
    words = ("run", str(SPEC), "--trials", "3", "--workers", "1", "--set", "evaluate=[spread-out, force-closure]")
    numbers = json.loads(said(*words, "--out", "run", "--json"))
    found = numbers["quality"]["spread_out"]
    assert (found["wide"], found["of"], found["share"], found["reasons"]) == (3, 3, 1.0, {})
    spans = [record["quality"]["spread-out"]["span"]["value"] for record in numbers["records"]]
    assert found["span"] == {"median": pytest.approx(np.median(spans)), "of": 3, "range": [min(spans), max(spans)]}
    assert numbers["quality"]["confusion"]["outcomes"]["converged"]["spread_out"] == 3
    console = " ".join(said("report", "run").split())
    assert "force closure spread out" in console
    assert f"spread out, medians: span {np.median(spans):.1f} m" in console
    page = Path("run/report.html").read_text("utf-8")
    assert "farther apart than a nut is wide" in page
    assert "span (m)" in page
    assert f"{np.median(spans):.3f}</td>" in page


@pytest.mark.usefixtures("_added")
def test_an_added_grade_is_checked(tmp_path: Path) -> None:
    spec = tmp_path / "spec.yaml"
    spec.write_text(SPEC.read_text("utf-8") + "\nevaluate: [spread-out, spread-in]\n", encoding="utf-8")
    answer = CliRunner().invoke(app, ["validate", str(spec), "--json"])
    [fault] = json.loads(answer.stdout)["files"][0]["diagnostics"]
    assert fault["code"] == "unknown-value"
    known = "force-closure, ferrari-canny, grasp-matrix, lift, shake or spread-out"
    assert fault["message"] == f"expected {known}, found the text 'spread-in'"
    assert fault["hint"] == "did you mean spread-out?"
