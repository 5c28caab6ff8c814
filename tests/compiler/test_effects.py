"""Warnings of what nothing can come of: just there, and not a step before it; the shipped specs have none."""

from __future__ import annotations

import numpy as np
import pytest
from shipped import NAMES, SPECS

from graspdsl.compiler.program import examine

from .observations import observation
from .specs import floating, program, spec

SLIDE = "π_s|Γ Γ (π_gx|Γ Γ)"
PRESS, PLACE = "φ_f|τ_f(Γ) σ_f(Γ) (κ_f σ_n(Γ))", "φ_p|τ_p(Γ) σ_p(Γ) (π_gx|Γ Γ)"


def codes(text: str) -> list[str]:
    found = examine(text, "spec.yaml")
    assert found.program is not None
    return [diagnostic.code for diagnostic in found.diagnostics]


@pytest.mark.parametrize("name", NAMES)
def test_shipped_specs_ask_for_nothing_in_vain(name: str) -> None:
    """But for the residual that a controller compared with others does not lower."""
    found = {diagnostic.code for diagnostic in examine((SPECS / name).read_text("utf-8"), name).diagnostics}
    assert found <= {"residual-not-controlled"}


@pytest.mark.parametrize(
    ("formula", "least", "most"),
    [
        ("π_gx|{γ1, γ2, γ3} {γ1, γ2, γ3}", 0.0, 3.0),
        ("π_gx|{γ1, <γ2, γ3>} {γ1, <γ2, γ3>}", 0.0, 2.0),
        ("π_gx|<γ2, γ3> <γ2, γ3>", 0.0, 1.0),
        ("π_gx|γ1 γ1", 1.0, 1.0),
        ("π_gx|γ1 {γ1, γ_g}", 0.0, 2.0),
        ("π_gx|{γ1, <γ1, γ2>} {γ1, <γ1, γ2>}", 1.0, 2.0),
    ],
)
def test_a_net_force_lies_between_what_its_weights_allow(formula: str, least: float, most: float) -> None:
    """|ρ_f| of weighted unit vectors: at most Σw, at least the largest weight without all others."""

    def said(bound: float) -> set[str]:
        found = codes(floating(formula, until=f"force_residual: {bound!r}"))
        return set(found) - {"contact-twice"}

    assert said(most) == {"always-met"}
    if most > least:
        assert said(most - 0.01) == set()
    if least > 0.0:
        assert said(least - 0.01) == {"never-met"}
    else:
        assert said(0.01) == set()


def test_no_contacts_on_the_object_have_a_larger_moment_than_is_said() -> None:
    """Points anywhere in a box of the towel roll's size, with unit forces of any direction, stay below 0.306 m."""
    assert codes(spec(until="moment_residual: 0.31")) == ["always-met"]
    assert codes(spec(until="moment_residual: 0.30")) == []
    random, weights = np.random.default_rng(0), np.array([1.0, 0.5, 0.5])
    points = random.choice([-0.5, 0.5], size=(20000, 3, 3)) * [0.1, 0.1, 0.2]
    levers = points - np.einsum("k,nki->ni", weights, points)[:, None] / weights.sum()
    largest = np.einsum("k,nk->n", weights, np.linalg.norm(levers, axis=-1)).max()
    assert 0.2 < largest < 0.306


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        (spec("π_close|Γ Γ", until="force_error: 0.5"), ["always-met"]),
        (spec("π_close|Γ Γ", until="force_error: 0.49"), []),
        (spec("π_close|Γ Γ", until="contact: all, hold: 30"), []),
        (spec("π_close|Γ Γ", until="contact: all, hold: 30.1"), ["never-met"]),
        (floating("π_cstar|Γ Γ", until="force_residual: 0.1, hold: 15"), []),
        (floating("π_cstar|Γ Γ", until="force_residual: 0.1, hold: 15.1"), ["never-met"]),
        (floating("π_cstar|Γ Γ", until="force_residual: 0.1").replace("    until", "    hysteresis: 2\n    until"), []),
        (
            floating("π_cstar|Γ Γ", until="moment_residual: 0.1").replace("    until", "    hysteresis: 2\n    until"),
            ["no-effect"],
        ),
        (spec("π_close|Γ Γ", parameters="κ_f: 23"), []),
        (spec("π_close|Γ Γ", parameters="κ_f: 24"), ["beyond-strength"]),
        (spec("π_close|Γ Γ", parameters="κ_f: 0.031"), []),
        (spec("π_close|Γ Γ", parameters="κ_f: 0.03"), ["too-weak"]),
        (spec(SLIDE, control="damping: 1.5"), []),
        (spec(SLIDE, control="damping: 1.6"), ["over-damped"]),
        (spec(SLIDE, control="moment_gain: 2, step: 0.001, approach: 0.01, posture_gain: 0.1"), ["no-effect"]),
        (spec(SLIDE, control="displacement: sliding, nullspace: gradient, virtual: members, surface: tangent"), []),
        (spec(f"{PRESS} ◁ {PLACE}"), ["force-gives-way"]),
        (spec(f"{PLACE} ◁ {PRESS}"), []),
        (spec("π_close|γ1 γ1 ◁ φ_p|τ_p(γ2) σ_p(γ2) (0, 0, 0.1)"), []),
        (spec("π_close|Γ Γ ◁ φ_k|τ_k(all) σ_k(wrist)"), []),
        (floating("φ_fr|τ_frx(Γ) σ_fr(Γ) ◁ φ_mr|τ_mrx(Γ) σ_mr(Γ)"), []),
        (floating("π_fr|Γ Γ ◁ π_fr|Γ Γ"), ["no-effect"]),
    ],
)
def test_a_warning_begins_where_nothing_can_come_of_it(text: str, expected: list[str]) -> None:
    assert codes(text) == expected


def test_what_is_said_to_leave_nothing_leaves_nothing() -> None:
    """Position before force in the null space of its task: however the forces are, the hand does not press."""
    formulas = (f"{PRESS} ◁ {PLACE}", PLACE)
    (both,), (alone,) = (program(formula, control="nullspace: task").pipelines() for formula in formulas)
    for seed in range(5):
        moved, placed = (made.evaluate(observation(seed)).command.displacement for (made,) in (both, alone))
        np.testing.assert_allclose(moved, placed, atol=1e-9 * np.abs(placed).max())
