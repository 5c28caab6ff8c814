"""Things of others that fail as they are used: one complaint about them, whoever called, and nothing half written."""

from __future__ import annotations

from pathlib import Path

import pytest
from compiler.specs import floating
from typer.testing import CliRunner

import graspdsl as g
from graspdsl.cli.app import app

from .packages import HUBER, installed

ALL = "{γ1, γ2, γ3}"
PHI = floating(f"φ_h|τ_frx({ALL}) σ_fr({ALL})", until="force_residual: 0.05") + "trials: {count: 2}\n"
PLAIN = PHI.replace("φ_h", "φ_fr")
GRADED, WATCHED = f"{PLAIN}evaluate: [even]\n", f"{PLAIN}monitors: {{rebound: 0.1}}\n"
MONITOR = """
import numpy as np
from graspdsl.spec.outcomes import STROKES, Outcome
from graspdsl.spec.watching import Distance, Monitor

class Rebound(Monitor):
    key = "rebound"
    description = "rebounds"
    bound_type, default = Distance, 0.03
    outcome = Outcome("rebounded", "it rebounds", "#8f98a2", STROKES)

    def speaks(self, sight):
        {speaks}

    def detail(self, sight, place):
        {detail}
"""
GRADE = """
import numpy as np
from graspdsl.quality.grade import Grade, Quantity

class Even(Grade):
    name, about, definition, column = "even", "how even", "Evenness.", "even"
    quantities = (Quantity("index", "evenness"),)

    def of(self, grasp):
        {of}
"""
WORLD = """
from graspdsl.worlds.floating import Floating

class Sea(Floating):
    name = "sea"

    def make(self, settings):
        {make}
"""
FLEEING = """
class Odd(Exception):
    def __init__(self, one, other):
        super().__init__("odd")
"""
EVER = "return np.ones(len(sight.rows), bool)"
RUNNING = {
    "a monitor that raises": (
        MONITOR.format(speaks="1/0", detail="..."),
        WATCHED,
        "monitor rebound of kit 1.0 fails in",
    ),
    "one that leaves": (MONITOR.format(speaks="raise SystemExit(0)", detail="..."), WATCHED, "SystemExit: 0"),
    "one whose exception cannot travel": (
        FLEEING + MONITOR.format(speaks="raise Odd(1, 2)", detail="..."),
        WATCHED,
        "rebound of kit 1.0 fails in __init__.py:17: Odd: odd",
    ),
    "one of another shape": (
        MONITOR.format(speaks="return np.ones(7, bool)", detail="..."),
        WATCHED,
        "at work is the monitor rebound of kit 1.0",
    ),
    "one without words": (MONITOR.format(speaks=EVER, detail="return None"), WATCHED, "ValueError: detail: "),
    "a grade that raises": (GRADE.format(of="{}['index']"), GRADED, "grade even of kit 1.0 fails in __init__.py:10"),
    "one that gives nothing": (GRADE.format(of="return None"), GRADED, "ValueError: quality.even: "),
    "one that gives no number": (
        GRADE.format(of="return {'index': {'value': np.nan, 'reason': ''}}"),
        GRADED,
        "at work is the grade even of kit 1.0",
    ),
    "one that gives an array": (
        GRADE.format(of="return {'index': {'value': np.zeros(3), 'reason': ''}}"),
        GRADED,
        "TypeError: Object of type ndarray",
    ),
    "a world that raises": (
        WORLD.format(make="1/0"),
        PLAIN.replace("world: floating", "world: sea"),
        "the world sea of kit 1.0 fails in __init__.py:8: ZeroDivisionError",
    ),
}
OFFERS = {
    "monitors": {"rebound": "kit:Rebound"},
    "grades": {"even": "kit:Even"},
    "worlds": {"sea": "kit:Sea"},
    "potentials": {"phi_h": "kit:Huber"},
}


@pytest.mark.parametrize(("module", "text", "said"), RUNNING.values(), ids=RUNNING)
def test_a_run_that_a_thing_fails_in_is_refused(site: Path, tmp_path: Path, module: str, text: str, said: str) -> None:
    installed(site, module, OFFERS)
    with pytest.raises(g.DiagnosticError) as caught:
        g.run(g.loads(text), out=tmp_path / "run", workers=1, progress=False)
    [found] = caught.value.diagnostics
    assert found.code == "plugin-failed"
    assert said in found.message
    assert found.hint == "hold it against its contract: graspdsl check-plugin kit"
    assert len(g.open_run(tmp_path / "run").trials) == 0


@pytest.mark.slow
@pytest.mark.parametrize("case", ["one that leaves", "one whose exception cannot travel"])
def test_so_it_is_with_workers(site: Path, tmp_path: Path, case: str) -> None:
    module, text, said = RUNNING[case]
    installed(site, module, OFFERS)
    with pytest.raises(g.DiagnosticError) as caught:
        g.run(g.loads(text), out=tmp_path / "run", workers=2, progress=False)
    assert said in str(caught.value)
    assert caught.value.diagnostics[0].code == "plugin-failed"


CHECKED = {
    "that raises": ("\n    def gradient(self, *_):\n        1/0", "the potential φ_h of kit 1.0 fails in"),
    "of another shape": ("\n    def gradient(self, *_):\n        return [0.0] * 7", "at work is the potential φ_h of"),
}


@pytest.mark.parametrize(("more", "said"), CHECKED.values(), ids=CHECKED)
def test_a_spec_is_checked_all_the_same(site: Path, more: str, said: str) -> None:
    installed(site, HUBER + more, OFFERS)
    with pytest.raises(g.DiagnosticError) as caught:
        g.loads(PHI)
    [found] = caught.value.diagnostics
    assert found.code == "plugin-failed"
    assert said in found.message


def test_the_command_line_calls_it_no_bug(site: Path, tmp_path: Path) -> None:
    installed(site, RUNNING["one that leaves"][0], OFFERS)
    (tmp_path / "spec.yaml").write_text(WATCHED, "utf-8")
    done = CliRunner().invoke(app, ["run", str(tmp_path / "spec.yaml"), "--workers", "1", "--out", str(tmp_path / "r")])
    assert done.exit_code == 1
    assert "error[plugin-failed]: the monitor rebound of kit 1.0 fails in __init__.py:13" in done.stderr


def test_a_controller_says_whose_fault_it_is(site: Path) -> None:
    installed(site, HUBER + "\n    def gradient(self, *given):\n        return {}[given[0].ndim]", OFFERS)
    controller = g.compile("φ_h|τ_frx(Γ) σ_fr(Γ)")
    with pytest.raises(g.DiagnosticError, match=r"the potential φ_h of kit 1\.0 fails in __init__\.py:13: KeyError: "):
        controller(controller.example())
