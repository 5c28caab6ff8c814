"""Tables of text and the tree it stands for."""

from __future__ import annotations

import pytest

from graspdsl.notation.parser import parse_expression, parse_head, parse_resources
from graspdsl.notation.printer import to_ascii, to_unicode
from graspdsl.notation.tree import (
    Abbreviation,
    Controller,
    Expression,
    Head,
    Name,
    Resources,
    ResourceSet,
    ScaledSensor,
    SubjectTo,
    Then,
    Transform,
    Vector,
    Virtual,
)

G = Name("Γ")
A, B, C = (Abbreviation(Name(name)) for name in ("π_a", "π_b", "π_c"))


def _controller(letters: str, displaced: str = "", reference: Vector | Name | ScaledSensor | None = None) -> Controller:
    effector = Transform(Name(f"τ_{letters}{displaced}"), G)
    return Controller(Name(f"φ_{letters}"), effector, Transform(Name(f"σ_{letters}"), G), reference)


GRASP = Abbreviation(Name("π_gx"), (G,), (G,))
FORCE = "φ_f|τ_f(Γ) σ_f(Γ)"

EXPRESSIONS: list[tuple[str, Expression]] = [
    ("π_a", A),
    ("((π_a))", A),
    ("π_gx|Γ Γ", GRASP),
    ("pi_gx|G G", GRASP),
    ("π_gx｜Γ　Γ", GRASP),
    ("π_s|Γ Γ (π_gx|Γ Γ)", Abbreviation(Name("π_s"), (G,), (G,), GRASP)),
    ("π_s|Γ Γ ((π_gx|Γ Γ))", Abbreviation(Name("π_s"), (G,), (G,), GRASP)),
    (
        "π_sq|(Γ_m, Γ_τ) (Γ_m, Γ_σ) (x_ref)",
        Abbreviation(Name("π_sq"), (Name("Γ_m"), Name("Γ_τ")), (Name("Γ_m"), Name("Γ_σ")), Name("x_ref")),
    ),
    (
        "π_g|<γ₁,γ_2>{g1, ⟨γ2, <γ3, γ_g>⟩}",
        Abbreviation(
            Name("π_g"),
            (Virtual((Name("γ1"), Name("γ2"))),),
            (ResourceSet((Name("γ1"), Virtual((Name("γ2"), Virtual((Name("γ3"), Name("γ_g"))))))),),
        ),
    ),
    ("π_g|{} <>", Abbreviation(Name("π_g"), (ResourceSet(()),), (Virtual(()),))),
    (
        "φ_mr|τ_mrx(Γ) σ_mr(Γ) ◁ φ_fr|τ_frx(Γ) σ_fr(Γ)",
        SubjectTo((_controller("mr", "x"), _controller("fr", "x"))),
    ),
    (
        "phi_mr|tau_mrx(G)sigma_mr(G)<|phi_fr|tau_frx(G)sigma_fr(G)",
        SubjectTo((_controller("mr", "x"), _controller("fr", "x"))),
    ),
    (f"{FORCE} (1, -0.5, 1e-3, .5, 2.)", _controller("f", reference=Vector((1, -0.5, 1e-3, 0.5, 2)))),
    (f"{FORCE} (−1)", _controller("f", reference=Vector((-1,)))),
    (f"{FORCE} (x_ref)", _controller("f", reference=Name("x_ref"))),
    (f"{FORCE}(σ_n(Γ))", _controller("f", reference=ScaledSensor(None, Transform(Name("σ_n"), G)))),
    (f"{FORCE}(0.5σ_n(Γ))", _controller("f", reference=ScaledSensor(0.5, Transform(Name("σ_n"), G)))),
    (
        f"{FORCE} (kappa_f sigma_n(G))",
        _controller("f", reference=ScaledSensor(Name("κ_f"), Transform(Name("σ_n"), G))),
    ),
    ("π_a ◁ π_b ◁ π_c", SubjectTo((A, B, C))),
    ("π_a ⊲ π_b ◃ π_c", SubjectTo((A, B, C))),
    ("(π_a ◁ π_b ◁ π_c)", SubjectTo((A, B, C))),
    ("(π_a ◁ π_b) ◁ π_c", SubjectTo((SubjectTo((A, B)), C))),
    ("π_a ◁ (π_b ◁ π_c)", SubjectTo((A, SubjectTo((B, C))))),
    ("(π_a then π_b) ◁ π_c", SubjectTo((Then((A, B)), C))),
    ("π_a then π_b ◁ π_c", Then((A, SubjectTo((B, C))))),
    ("π_a then (π_b then π_c)", Then((A, Then((B, C))))),
    ("(π_a)then(π_b)then(π_c)", Then((A, B, C))),
    ("π_g|Γ <γ1><|π_b", SubjectTo((Abbreviation(Name("π_g"), (G,), (Virtual((Name("γ1"),)),)), B))),
    ("π_g|Γ then_x", Abbreviation(Name("π_g"), (G,), (Name("then_x"),))),
]

HEADS: list[tuple[str, Head]] = [
    ("π_mine", Head(Name("π_mine"))),
    ("π_gx|Γ_τ Γ_σ", Head(Name("π_gx"), (Name("Γ_τ"),), (Name("Γ_σ"),))),
    ("π_s|Γ_m Γ_m (x_ref)", Head(Name("π_s"), (Name("Γ_m"),), (Name("Γ_m"),), Name("x_ref"))),
    (
        "pi_sq|(G_m, G_tau) (G_m, G_sigma) (x_ref)",
        Head(Name("π_sq"), (Name("Γ_m"), Name("Γ_τ")), (Name("Γ_m"), Name("Γ_σ")), Name("x_ref")),
    ),
]

RESOURCES: list[tuple[str, Resources]] = [
    ("γ1", Name("γ1")),
    (" arm ", Name("arm")),
    ("<γ2, γ3>", Virtual((Name("γ2"), Name("γ3")))),
    ("{γ1, <γ2,γ3>}", ResourceSet((Name("γ1"), Virtual((Name("γ2"), Name("γ3")))))),
    ("{}", ResourceSet(())),
]

PRINTED = [
    ("φ_mr|τ_mrx(Γ) σ_mr(Γ) ◁ φ_fr|τ_frx(Γ) σ_fr(Γ)", "phi_mr|tau_mrx(G) sigma_mr(G) <| phi_fr|tau_frx(G) sigma_fr(G)"),
    ("π_s|Γ Γ (π_gx|Γ Γ)", "pi_s|G G (pi_gx|G G)"),
    ("φ_f|τ_f(Γ) σ_f(Γ) (κ_f σ_n(Γ))", "phi_f|tau_f(G) sigma_f(G) (kappa_f sigma_n(G))"),
    ("φ_f|τ_f(Γ) σ_f(Γ) (1, -0.5, 1e-07)", "phi_f|tau_f(G) sigma_f(G) (1, -0.5, 1e-07)"),
    ("π_sq|(Γ_m, Γ_τ) (Γ_m, Γ_σ) (x_ref)", "pi_sq|(G_m, G_tau) (G_m, G_sigma) (x_ref)"),
    ("π_g|{γ1, <γ2, γ3>} {γ1, γ_g}", "pi_g|{g1, <g2, g3>} {g1, g_g}"),
    ("(π_a then π_b) ◁ π_c then (π_d then π_gθ)", "(pi_a then pi_b) <| pi_c then (pi_d then pi_gtheta)"),
]


@pytest.mark.parametrize(("text", "tree"), EXPRESSIONS)
def test_expression(text: str, tree: Expression) -> None:
    assert parse_expression(text) == tree


@pytest.mark.parametrize(("text", "tree"), HEADS)
def test_head(text: str, tree: Head) -> None:
    assert parse_head(text) == tree


@pytest.mark.parametrize(("text", "tree"), RESOURCES)
def test_resources(text: str, tree: Resources) -> None:
    assert parse_resources(text) == tree


@pytest.mark.parametrize(("unicode", "ascii_text"), PRINTED)
def test_printed_form(unicode: str, ascii_text: str) -> None:
    assert to_unicode(parse_expression(ascii_text)) == unicode
    assert to_ascii(parse_expression(unicode)) == ascii_text
