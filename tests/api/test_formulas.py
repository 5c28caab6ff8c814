"""Formulas compose in Python as they do in text."""

from __future__ import annotations

import numpy as np
import pytest
from compiler.observations import command, observation
from hypothesis import given, settings
from notation import strategies

import graspdsl as g
from graspdsl.notation.tree import Expression

MOMENT, FORCE = "φ_mr|τ_mrx(Γ) σ_mr(Γ)", "φ_fr|τ_frx(Γ) σ_fr(Γ)"
CLOSE, GRASP = "π_close|Γ Γ", "π_s|Γ Γ (π_gx|Γ Γ)"


def test_a_formula_is_written_in_unicode_and_in_ascii() -> None:
    formula = g.parse("pi_s|G G (pi_gx|G G)")
    assert (str(formula), formula.ascii) == (GRASP, "pi_s|G G (pi_gx|G G)")
    assert repr(formula) == f"parse('{GRASP}')"
    assert formula == g.parse(GRASP)
    assert len({formula, g.parse(GRASP), g.parse(CLOSE)}) == 2


def test_the_chapters_composition() -> None:
    """Eq. 4.30: the moment residual subject to the force residual."""
    composed = g.parse(MOMENT).subject_to(g.parse(FORCE))
    assert composed == g.parse(f"{MOMENT} ◁ {FORCE}")
    assert g.parse(CLOSE).then(composed) == g.parse(f"{CLOSE} then {MOMENT} ◁ {FORCE}")


def test_text_stands_for_a_formula() -> None:
    assert g.parse(MOMENT).subject_to(FORCE) == g.parse(f"{MOMENT} ◁ {FORCE}")
    assert g.parse(CLOSE).then(GRASP) == g.parse(f"{CLOSE} then {GRASP}")
    with pytest.raises(g.DiagnosticError, match="φ_fr"):
        g.parse(MOMENT).subject_to("φ_fr|")


def test_brackets_stand_where_they_mean_something() -> None:
    a, b, c = map(g.parse, ("π_a", "π_b", "π_c"))
    assert str(a.subject_to(b, c)) == "π_a ◁ π_b ◁ π_c"
    assert str(a.subject_to(b.subject_to(c))) == "π_a ◁ π_b ◁ π_c"
    assert str(a.subject_to(b).subject_to(c)) == "(π_a ◁ π_b) ◁ π_c"
    assert str(a.then(b).then(c)) == str(a.then(b.then(c))) == str(a.then(b, c)) == "π_a then π_b then π_c"
    assert str(a.subject_to(b.then(c))) == "π_a ◁ (π_b then π_c)"
    assert str(a.then(b.subject_to(c))) == "π_a then π_b ◁ π_c"


@pytest.mark.slow
@settings(deadline=None)
@given(first=strategies.expressions, second=strategies.expressions, third=strategies.expressions)
def test_what_is_composed_reads_back(first: Expression, second: Expression, third: Expression) -> None:
    one, two, three = map(g.Formula, (first, second, third))
    for formula in (
        one,
        one.subject_to(two),
        one.subject_to(two, three),
        one.subject_to(two).subject_to(three),
        one.then(two).subject_to(three),
        one.subject_to(two).then(three),
    ):
        again = g.parse(str(formula))
        assert again == formula == g.parse(formula.ascii)
        assert hash(again) == hash(formula)


@pytest.mark.slow
def test_a_chain_on_the_right_needs_no_brackets_and_one_on_the_left_does() -> None:
    """By what the controllers command: three levels, none of which leaves the others alone."""
    posture = "φ_k|τ_k(all) σ_k(all)"
    place, force = "φ_p|τ_p(Γ) σ_p(Γ) (0, 0, 0, 0.1, 0.1, 0.1)", "φ_f|τ_f(Γ) σ_f(Γ) (κ_f σ_n(Γ))"
    seen = observation(3)
    chain, right, left = (
        f"{posture} ◁ {place} ◁ {force}",
        f"{posture} ◁ ({place} ◁ {force})",
        (f"({posture} ◁ {place}) ◁ {force}"),
    )
    np.testing.assert_array_equal(command(chain, seen), command(right, seen))
    assert np.abs(command(chain, seen) - command(left, seen)).max() > 1e-6
    assert g.parse(posture).subject_to(g.parse(place).subject_to(force)) == g.parse(chain)
    assert g.parse(posture).subject_to(place).subject_to(force) == g.parse(left)


def test_mistakes_have_their_places() -> None:
    with pytest.raises(g.DiagnosticError) as refusal:
        g.parse("π_s|Γ Γ (π_gx|Γ")
    [found] = refusal.value.diagnostics
    assert found.span is not None
    assert (found.span.line, found.span.column) == (1, 9)
