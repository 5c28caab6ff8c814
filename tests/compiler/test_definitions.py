"""Controllers of the spec's own are checked where they stand, whether the program uses them or not."""

from __future__ import annotations

import time

import pytest

from graspdsl.compiler.program import examine
from graspdsl.diagnostics import Diagnostic

from .specs import spec


def complaints(formula: str = "π_close|Γ Γ", **definitions: str) -> list[Diagnostic]:
    """What is said of a spec with these bodies of π_a, π_b … over Γ."""
    own = {f"π_{name}|Γ Γ": body for name, body in definitions.items()}
    return list(examine(spec(formula, controllers=own), "spec.yaml").diagnostics)


@pytest.mark.parametrize(
    ("definitions", "code", "line"),
    [
        ({"a": "φ_zz|τ_p(Γ) σ_p(Γ) (0)"}, "unknown-potential", 11),
        ({"a": "φ_f|τ_f(Γ_q) σ_f(Γ) (κ_f σ_n(Γ))"}, "unknown-resource", 11),
        ({"a": "φ_f|τ_f(Γ) σ_f(Γ) (κ_q σ_n(Γ))"}, "missing-parameter", 11),
        ({"a": "π_gx|Γ Γ ◁ π_close|Γ Γ"}, "mixed-spaces", 11),
        ({"a": "π_close|Γ Γ", "b": "π_gx|Γ Γ ◁ π_a|Γ Γ"}, "mixed-spaces", 12),
        ({"a": "π_s|Γ Γ (π_g|Γ Γ)"}, "wrong-reference", 11),
        ({"a": "φ_fr|τ_frx(Γ) σ_mr(Γ)"}, "wrong-sensor", 11),
        ({"a": "π_s|Γ Γ"}, "missing-reference", 11),
        ({"a": "π_nn|Γ Γ"}, "unknown-controller", 11),
        ({"a": "φ_fr|τ_frx({γ1, γ_g}) σ_fr(Γ)"}, "gravity-effector", 11),
        ({"a": "π_close|{Γ, <γ1>} {Γ, <γ1>}"}, "single-virtual-contact", 11),
        ({"a": "π_b|Γ Γ", "b": "π_a|Γ Γ"}, "definition-cycle", 12),
        ({"a": "π_cstar|Γ Γ ◁ π_fr|Γ Γ"}, "then-inside", 11),
        ({"a": "φ_zz|τ_p(Γ) σ_p(Γ) (π_gx|Γ Γ)"}, "unknown-potential", 11),
        ({"a": "π_close|{γ1, <γ1, γ2>} Γ ◁ π_zz|Γ Γ"}, "unknown-controller", 11),
    ],
)
def test_a_fault_that_no_phase_meets_is_reported(definitions: dict[str, str], code: str, line: int) -> None:
    found = complaints(**definitions)
    assert (code, line) in [(diagnostic.code, diagnostic.span and diagnostic.span.line) for diagnostic in found]


def test_faults_are_told_once_where_they_stand_and_not_where_they_are_used() -> None:
    """Neither a use in a phase nor one in another definition repeats them."""
    found = complaints("π_b|Γ Γ", a="φ_fr|τ_frx(Γ) σ_mr(Γ)", b="π_s|Γ Γ (π_a|Γ Γ)")
    assert [(diagnostic.code, diagnostic.span and diagnostic.span.line) for diagnostic in found] == [
        ("wrong-sensor", 11)
    ]


def test_a_warning_is_told_where_it_stands_and_not_again_at_a_use() -> None:
    found = complaints("π_a|Γ Γ", a="φ_f|τ_f({γ1, <γ1, γ2>}) σ_f({γ1, <γ1, γ2>}) (κ_f σ_n({γ1, <γ1, γ2>}))")
    lines = {diagnostic.span and diagnostic.span.line for diagnostic in found}
    assert ({diagnostic.code for diagnostic in found}, lines) == ({"contact-twice"}, {11})


@pytest.mark.parametrize(
    "body",
    [
        "π_close|Γ Γ",
        "φ_p|τ_p(Γ) σ_p(Γ) (0, 0, 0)",
        "φ_p|τ_p(Γ) σ_p(Γ_m) (σ_p(Γ_m))",
        "φ_k|τ_k(Γ) σ_k(Γ)",
        "φ_f|τ_f({Γ, γ1}) σ_f({Γ, γ1}) (κ_f σ_n({Γ, γ1}))",
        "π_s|Γ Γ (π_gx|Γ {γ1, Γ})",
    ],
)
def test_what_may_be_sound_for_some_arguments_is_not_complained_of(body: str) -> None:
    """Sizes and members are known only where a controller is used; a parameter hides a resource of its name."""
    text = spec("π_close|Γ Γ", controllers={"π_a|Γ Γ": body}, resources={"Γ_m": '"{γ1, γ2}"'})
    assert examine(text, "spec.yaml").diagnostics == ()


def test_what_only_the_arguments_make_wrong_is_told_at_the_use() -> None:
    [found] = complaints("π_a|Γ Γ", a="φ_p|τ_p(Γ) σ_p(Γ) (0, 0, 0)")
    assert (found.code, found.span and found.span.line) == ("wrong-size", 14)


def test_formulas_are_checked_beside_a_hand_that_is_not_there() -> None:
    text = spec("φ_zz|τ_p(Γ) σ_p(Γ) (0)", "φ_k|τ_k(flexion) σ_k(Γ_z)", scene="world: bullet, hand: baret, object: ball")
    codes = [diagnostic.code for diagnostic in examine(text, "spec.yaml").diagnostics]
    assert codes == ["unknown-hand", "unknown-potential", "unknown-resource"]


@pytest.mark.slow
def test_many_definitions_of_definitions_are_checked_in_moderate_time() -> None:
    """A chain of a thousand, and a thousand that each double what stands before."""
    began = time.perf_counter()
    chain = {"c0": "π_close|Γ Γ", **{f"c{i}": f"π_c{i - 1}|Γ Γ" for i in range(1, 1000)}}
    double = {"d0": "π_close|Γ Γ", **{f"d{i}": f"π_d{i - 1}|Γ Γ ◁ π_d{i - 1}|Γ Γ" for i in range(1, 1000)}}
    for definitions in (chain, double):
        assert [found.code for found in complaints(**definitions)] == ["formula-too-large"]
    assert time.perf_counter() - began < 60.0
