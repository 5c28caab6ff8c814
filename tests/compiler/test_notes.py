"""What ``explain`` notes of a formula before it is run."""

from __future__ import annotations

from pathlib import Path

import pytest

from graspdsl.compiler.explain import explained
from graspdsl.compiler.program import program_of, program_of_expression

PLAIN = "{γ1, γ2, γ3}"


@pytest.mark.parametrize("formula", [f"π_gx|{PLAIN} {PLAIN}", f"π_s|{PLAIN} {PLAIN} (π_gx|{PLAIN} {PLAIN})"])
def test_a_plain_sum_is_said_to_be_one(formula: str) -> None:
    """All contacts controlled, equal weights: ◁ takes nothing away there, also inside a reference."""
    [explanation] = explained(program_of_expression(formula))
    [note] = explanation.notes()
    assert note.startswith(f"◁ is a plain sum in φ_mr|τ_mrx({PLAIN}) σ_mr({PLAIN}) ◁ φ_fr|τ_frx({PLAIN}) σ_fr({PLAIN})")
    assert note in explanation.text()
    assert explanation.as_dict()["notes"] == [note]


@pytest.mark.parametrize("formula", ["π_gx|Γ Γ", f"π_gx|γ1 {PLAIN}", "π_gx|{γ1, γ2} {γ1, γ2, γ_g}", "π_close|Γ Γ"])
def test_where_projection_acts_nothing_is_said(formula: str) -> None:
    """A virtual contact, fewer contacts moved than sensed, gravity, or no ◁ of residuals."""
    [explanation] = explained(program_of_expression(formula))
    assert explanation.notes() == []


def test_one_word_turns_sliding_into_probing() -> None:
    """Under probing, a controller that slides contacts is carried out as what moves its reference."""
    text = (Path(__file__).resolve().parents[2] / "specs/towel_roll_two_contacts.yaml").read_text("utf-8")
    sliding = program_of(text, "spec").pipelines()
    probing = program_of(text, "spec", ("control.displacement=probing",)).pipelines()
    assert [pipeline.space for (pipeline,) in sliding] == ["q", "q"]
    assert [pipeline.space for (pipeline,) in probing] == ["q", "x"]
