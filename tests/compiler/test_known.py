"""What is said of a formula before it is run is what its numbers are, and where they are others nothing is said."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from compiler.observations import compiled, observation
from compiler.specs import floating
from graspdsl.compiler.alike import SAME_PROGRAM, known_of, same_by_law
from graspdsl.compiler.explain import explained
from graspdsl.compiler.known import facts_about
from graspdsl.compiler.program import examine_expression, program_of, program_of_expression
from graspdsl.spec.program import Control

PLAIN, VIRTUAL, EVEN = "{γ1, γ2, γ3}", "{γ1, <γ2, γ3>}", "{<γ1, γ2, γ3>}"
MANY = 200
ROUNDING = 1e-13  # of the longest displacement


def _terms(moved: str, sensed: str, space: str = "x") -> tuple[str, str, str]:
    """The moment's controller, the force's, and that of the wrench."""
    suffix = "" if space == "ψ" else space
    moment = f"φ_mr|τ_mr{suffix}({moved}) σ_mr({sensed})"
    force = f"φ_fr|τ_fr{suffix}({moved}) σ_fr({sensed})"
    return moment, force, f"φ_w|τ_w{suffix}({moved}) σ_w({sensed})"


CASES = [
    (PLAIN, PLAIN, "x", {}),
    (PLAIN, "{γ3, γ1, γ2}", "x", {}),
    ("{γ1, γ2}", "{γ1, γ2}", "x", {}),
    (PLAIN, PLAIN, "ψ", {}),
    (EVEN, EVEN, "x", {}),
    (PLAIN, PLAIN, "x", {"moment_gain": 0.25}),
    (PLAIN, PLAIN, "x", {"origin": "world"}),
    (PLAIN, PLAIN, "x", {"nullspace": "task"}),
    (PLAIN, PLAIN, "x", {"surface": "spherical"}),
    (PLAIN, PLAIN, "ψ", {"surface": "spherical"}),
    (EVEN, EVEN, "x", {"virtual": "common"}),
    (VIRTUAL, VIRTUAL, "x", {}),
    ("{γ2, γ3}", PLAIN, "x", {}),
    (PLAIN, "{γ1, γ2, γ3, γ_g}", "x", {}),
]


def _difference(one: str, other: str, control: dict[str, Any]) -> float:
    """The largest difference of two formulas' displacements over random observations, of the longest of them."""
    seen = observation(2041, MANY)
    mine, theirs = (compiled(formula, **control).ticks(seen).displacement for formula in (one, other))
    return float(np.abs(mine - theirs).max() / np.abs(mine).max())


@pytest.mark.parametrize(("moved", "sensed", "space", "control"), CASES)
def test_what_is_known_is_so_and_what_is_so_is_known(
    moved: str, sensed: str, space: str, control: dict[str, Any]
) -> None:
    """The projector takes nothing away, the order does not matter, and φ_w moves alike: said where it is true."""
    moment, force, wrench = _terms(moved, sensed, space)
    composite, exchanged = f"{moment} ◁ {force}", f"{force} ◁ {moment}"
    phase, _ = examine_expression(composite)
    said = [fact.says for fact in facts_about(phase.stages[0], Control(**control))]
    pipeline, seen = compiled(composite, **control), observation(2041, MANY)
    values, [projection] = pipeline.values(seen), pipeline.projections
    taken = np.abs(values[projection.before] - values[projection.after]).max() / np.abs(values[projection.before]).max()
    assert (taken < ROUNDING) == any("plain sum" in fact for fact in said)
    assert (_difference(composite, exchanged, control) < ROUNDING) == any("moves as φ_fr" in fact for fact in said)
    assert (_difference(composite, wrench, control) < ROUNDING) == any("moves as φ_w" in fact for fact in said)


@pytest.mark.parametrize("formula", [f"π_gx|{PLAIN} {PLAIN}", f"π_s|{PLAIN} {PLAIN} (π_gx|{PLAIN} {PLAIN})"])
def test_explain_tells_what_is_known(formula: str) -> None:
    """Also inside a reference: what moves, and why."""
    [explanation] = explained(program_of_expression(formula))
    plain, order, whole = explanation.notes()
    assert plain.startswith(f"◁ is a plain sum in φ_mr|τ_mrx({PLAIN}) σ_mr({PLAIN}) ◁ φ_fr|τ_frx({PLAIN})")
    assert "F·(F × M) = 0" in plain
    assert f"moves as φ_fr|τ_frx({PLAIN}) σ_fr({PLAIN}) ◁ φ_mr" in order
    assert f"moves as φ_w|τ_wx({PLAIN}) σ_w({PLAIN})" in whole
    assert all(note in explanation.text() for note in explanation.notes())
    assert explanation.as_dict()["notes"] == explanation.notes()


@pytest.mark.parametrize("formula", ["π_gx|Γ Γ", "π_close|Γ Γ"])
def test_where_nothing_is_known_nothing_is_said(formula: str) -> None:
    """A virtual contact, or no ◁ of residuals."""
    assert known_of(program_of_expression(formula)) == []


def test_programs_that_do_the_same_are_known_to() -> None:
    """By the same law to the last bit, by another but for rounding; not where anything else is another."""
    moment, force, wrench = _terms(PLAIN, PLAIN)

    def made(*formulas: str, **parts: str) -> Any:
        return program_of(floating(*formulas, **{"until": "force_residual: 0.1, moment_residual: 0.005", **parts}), "s")

    composite = made(f"{moment} ◁ {force}")
    assert same_by_law(composite, made(f"{moment} ◁ {force}")) == SAME_PROGRAM
    to_the_limit = program_of(floating(f"{moment} ◁ {force}"), "s", ("program.0.full_time=true",))
    assert same_by_law(program_of(floating(f"{moment} ◁ {force}"), "s"), to_the_limit) is None
    for formula in (f"{force} ◁ {moment}", wrench):
        why = same_by_law(composite, made(formula))
        assert why is not None
        assert "right angles" in why
    assert same_by_law(made(wrench), made(f"{force} ◁ {moment}")) is not None
    assert same_by_law(composite, made(force)) is None
    assert same_by_law(composite, made(wrench, until="force_residual: 0.2, moment_residual: 0.005")) is None
    halved = "moment_gain: 0.5"
    assert same_by_law(made(f"{moment} ◁ {force}", control=halved), made(wrench, control=halved)) is None
    assert same_by_law(made(f"{moment} ◁ {force}", control=halved), made(f"{force} ◁ {moment}", control=halved))


def test_one_word_turns_sliding_into_probing() -> None:
    """Under probing, a controller that slides contacts is carried out as what moves its reference."""
    text = (Path(__file__).resolve().parents[2] / "specs/towel_roll_two_contacts.yaml").read_text("utf-8")
    sliding = program_of(text, "spec").pipelines()
    probing = program_of(text, "spec", ("control.displacement=probing",)).pipelines()
    assert [pipeline.space for (pipeline,) in sliding] == ["q", "q"]
    assert [pipeline.space for (pipeline,) in probing] == ["q", "x"]
