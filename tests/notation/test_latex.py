"""LaTeX as people print the notation: the same trees as the Unicode spelling, and complaints at their places."""

from __future__ import annotations

import random
import re
import time

import pytest

from graspdsl.diagnostics import DiagnosticError, SourceText, Span
from graspdsl.notation.names import canonical
from graspdsl.notation.papers import definitions_in
from graspdsl.notation.parser import (
    parse_definition,
    parse_expression,
    parse_head,
    parse_resource_definition,
    parse_resources,
)
from graspdsl.notation.printer import to_latex

FR = r"\phi_{fr}|_{\tau_{fr}(\Gamma_\tau)}^{\sigma_{fr}(\Gamma_\sigma)}"
MR = r"\phi_{mr}|_{\tau_{mr}(\Gamma_\tau)}^{\sigma_{mr}(\Gamma_\sigma)}"
POSITION = r"\phi_p|_{\tau_p(\Gamma_m)}^{\sigma_p(\Gamma_m)}(\mathbf{x}_{ref})"
FORCE = r"\phi_f|_{\tau_f(\Gamma_m)}^{\sigma_f(\Gamma_m)}(\kappa_f\sigma_n(\Gamma_m))"
POSTURE = r"\phi_k|_{\tau_k(\Gamma_\tau)}^{\sigma_k(\Gamma_\sigma)}"
FORCE_MEANT = "φ_f|τ_f(Γ_m) σ_f(Γ_m) (κ_f σ_n(Γ_m))"

# Both sides of definitions; the left one is empty of an expression alone.
DEFINITIONS = [
    (rf"\pi_{{fr}} = {FR}", "π_fr", "φ_fr|τ_fr(Γ_τ) σ_fr(Γ_σ)"),
    (
        rf"\pi_g|_{{\Gamma_\tau}}^{{\Gamma_\sigma}} \equiv {MR} \triangleleft {FR}. \quad (4.18)",
        "π_g|Γ_τ Γ_σ",
        "φ_mr|τ_mr(Γ_τ) σ_mr(Γ_σ) ◁ φ_fr|τ_fr(Γ_τ) σ_fr(Γ_σ)",
    ),
    (POSITION, "", "φ_p|τ_p(Γ_m) σ_p(Γ_m) (x_ref)"),
    (
        rf"\pi_s|_{{\Gamma_m}}^{{\Gamma_m}}(\mathbf{{x}}_{{ref}}) \equiv {POSITION} \lhd {FORCE}. \quad (4.24)",
        "π_s|Γ_m Γ_m (x_ref)",
        f"φ_p|τ_p(Γ_m) σ_p(Γ_m) (x_ref) ◁ {FORCE_MEANT}",
    ),
    (rf"{POSTURE} \triangleleft {FORCE}, \quad (4.25)", "", f"φ_k|τ_k(Γ_τ) σ_k(Γ_σ) ◁ {FORCE_MEANT}"),
    (
        r"\pi_{sq}|_{\Gamma_m, \Gamma_\tau}^{\Gamma_m, \Gamma_\sigma}(\mathbf{x}_{ref}) \equiv \pi_a",
        "π_sq|(Γ_m, Γ_τ) (Γ_m, Γ_σ) (x_ref)",
        "π_a",
    ),
    (
        r"\pi_{gx}|_{\Gamma_\tau}^{\Gamma_\sigma} = \phi_{mr}|_{\tau_{mr_x}(\Gamma_\tau)}^{\sigma_{mr}(\Gamma_\sigma)}",
        "π_gx|Γ_τ Γ_σ",
        "φ_mr|τ_mrx(Γ_τ) σ_mr(Γ_σ)",
    ),
    (
        r"\pi_{rg\theta}|_{\Gamma_\tau}^{\Gamma_\sigma} \equiv \phi_r|_{\tau_r(\Gamma_\tau)}^{\sigma_r(\Gamma_\sigma)} "
        r"\left( \pi_{g\theta}|_{\Gamma_\tau}^{\Gamma_\sigma} \right). \quad (4.41)",
        "π_rgθ|Γ_τ Γ_σ",
        "φ_r|τ_r(Γ_τ) σ_r(Γ_σ) (π_gθ|Γ_τ Γ_σ)",
    ),
    (
        r"\pi_s|_{\{\gamma_1, \gamma_{23}\}} \left( \pi_{gx}|_{\{\gamma_1, \gamma_{23}\}} \right)",
        "",
        "π_s|{γ1, γ23} {γ1, γ23} (π_gx|{γ1, γ23} {γ1, γ23})",
    ),
    (r"\pi_a := \pi_b", "π_a", "π_b"),
    ("π_a ≡ π_b", "π_a", "π_b"),
]

PLAIN = "φ_fr|τ_fr(Γ) σ_fr(Γ)"
SPELLINGS = [
    (r"\phi_{fr}|^{\sigma_{fr}(\Gamma)}_{\tau_{fr}(\Gamma)}", PLAIN),
    (r"\left.\phi_{fr}\right|_{\tau_{fr}(\Gamma)}^{\sigma_{fr}(\Gamma)}", PLAIN),
    (r"\phi_{fr} \Bigr\vert_{\tau_{fr}\left(\Gamma\right)}^{\sigma_{fr}\bigl(\Gamma\bigr)}", PLAIN),
    (r"{\varphi}_{\text{fr}} \mid _ { \tau _ { \mathrm{ f r } } (\Gamma) } ^ { \sigma _ { f r } (\Gamma) }", PLAIN),
    (r"\boldsymbol{\phi_{fr}|_{\tau_{fr}(\Gamma)}^{\sigma_{fr}(\Gamma)}}", PLAIN),
    (r"φ_{fr}|_{τ_{fr}(Γ)}^{σ_{fr}(Γ)}", PLAIN),
    (r"$\pi_a$ \lhd $\pi_b \vartriangleleft \pi_c$", "π_a ◁ π_b ◁ π_c"),
    (
        "\\begin{equation}\\label{eq:a_b}\n  \\pi_a % the first\n  &\\lhd\\\\[2pt] \\pi_b, \\tag{7}\n\\end{equation}",
        "π_a ◁ π_b",
    ),
    (r"\[\pi_a\,\triangleleft\;\!\pi_b~. \]", "π_a ◁ π_b"),
    (r"\pi_a \;\text{then}\; (\pi_b \mathbin{\triangleleft} \pi_c)", "π_a then (π_b ◁ π_c)"),
    (r"\pi_g|_{\langle\gamma_2,\gamma_3\rangle}^\Gamma", "π_g|<γ2, γ3> Γ"),
    (r"\pi_g|_{\Gamma_m, \Gamma}^{(\Gamma_m, \Gamma)}", "π_g|(Γ_m, Γ) (Γ_m, Γ)"),
    (r"\pi_g|\Gamma\Gamma", "π_g|Γ Γ"),
    ("π_{gx}|Γ Γ", "π_gx|Γ Γ"),
    ("π_g|{γ_{1}, γ_{g}} Γ", "π_g|{γ1, γ_g} Γ"),
    (r"\pi_a|_\Gamma^\Gamma (1.5 \times 10^{-3}, -10^{2}, 2\cdot10^{1})", "π_a|Γ Γ (1.5e-3, -1e2, 2e1)"),
    (r"\pi_a|_\Gamma^\Gamma (0.5\,\sigma_n(\Gamma))", "π_a|Γ Γ (0.5 σ_n(Γ))"),
    (r"\pi_a|_\Gamma^\Gamma (\kappa_f \cdot \sigma_n(\Gamma))", "π_a|Γ Γ (κ_f σ_n(Γ))"),
    (r"\pi_a|_\Gamma^\Gamma (4.18)", "π_a|Γ Γ (4.18)"),
]


@pytest.mark.parametrize(("latex", "head", "body"), DEFINITIONS)
def test_definitions(latex: str, head: str, body: str) -> None:
    assert parse_definition(latex) == (parse_head(head) if head else None, parse_expression(body))


@pytest.mark.parametrize(("latex", "plain"), SPELLINGS)
def test_spellings(latex: str, plain: str) -> None:
    assert parse_expression(latex) == parse_expression(plain)


@pytest.mark.parametrize(
    ("latex", "name", "meaning"),
    [
        (r"\gamma_{23} = \{\gamma_2, \gamma_3\}", "γ23", "<γ2, γ3>"),
        (r"\alpha = \{\gamma_2, \gamma_3\}", "α", "{γ2, γ3}"),
        (r"\Gamma_m := \{\gamma_1, \langle\gamma_2, \gamma_\alpha\rangle\}.", "Γ_m", "{γ1, <γ2, γ_α>}"),
    ],
)
def test_definitions_of_resources(latex: str, name: str, meaning: str) -> None:
    assert parse_resource_definition(latex) == (parse_resources(name), parse_resources(meaning))
    with pytest.raises(DiagnosticError, match="this defines resources"):
        parse_definition(latex)


@pytest.mark.parametrize(
    ("latex", "name"),
    [
        (r"\gamma_{23}", "γ23"),
        (r"$\mathbf{x}_{ref}$", "x_ref"),
        (r"\tau_{mr_r}", "τ_mrr"),
        (r"\frac{1}{2}", r"\frac{1}{2}"),
    ],
)
def test_names(latex: str, name: str) -> None:
    assert canonical(latex) == name


def test_places_are_those_of_the_source() -> None:
    tree = parse_expression(SourceText.of("\\pi_a|^{\\Gamma}_{\\gamma_{1}}\n \\triangleleft \\pi_b", line=7, column=5))
    first, second = tree.terms  # a composition
    assert (first.span, second.span) == (Span(7, 5, 7, 32), Span(8, 16, 8, 21))
    assert first.effector[0].span == Span(7, 22, 7, 32)


def test_what_is_written_once_and_read_twice_is_told_once() -> None:
    with pytest.raises(DiagnosticError) as caught:
        parse_expression(r"\pi_a|_{\{\gamma_1; \gamma_2\}}")
    assert len(caught.value.diagnostics) == 1


def test_doubled_sets_do_not_grow_without_end() -> None:
    latex = r"\pi_a|_{" * 40 + r"\Gamma" + "}" * 40
    with pytest.raises(DiagnosticError) as caught:
        parse_expression(latex)
    assert {fault.code for fault in caught.value.diagnostics} == {"too-long"}


@pytest.mark.parametrize(
    ("latex", "code"),
    [
        ("|_" * 60 + "x$", "too-long"),
        ("|_" * 300 + "x$", "too-deep"),
        ("|^" * 300 + "x$", "too-deep"),
        (r"\bm" * 300 + " x", "too-deep"),
        (r"\aa" * 3000, "unknown-command"),
    ],
)
def test_what_nests_or_grows_without_end_is_refused(latex: str, code: str) -> None:
    with pytest.raises(DiagnosticError) as caught:
        parse_expression(latex)
    assert {said.code for said in caught.value.diagnostics} == {code}
    assert len(caught.value.diagnostics) <= 20


def test_a_number_is_an_equations_or_a_reference() -> None:
    controller = r"\phi_{k}|_{\tau_k(all)}^{\sigma_k(all)}"
    assert parse_expression(rf"{controller} \quad (4.25)") == parse_expression(controller)
    assert parse_expression(rf"{controller} \quad (0.5)") == parse_expression(f"{controller} (0.5)")


def test_print_is_as_in_print() -> None:
    plain = "π_q|(Γ_m, Γ_τ) ({γ1, <γ2, γ3>}, Γ) (x_ref) ◁ φ_f|τ_f(Γ) σ_f(Γ) (1e-07)"
    assert to_latex(parse_expression(plain)) == (
        r"\pi_{q}|_{\Gamma_{m}, \Gamma_{\tau}}^{\{\gamma_{1}, \langle \gamma_{2}, \gamma_{3} \rangle\}, \Gamma}"
        r" (x_{ref}) \triangleleft \phi_{f}|_{\tau_{f}(\Gamma)}^{\sigma_{f}(\Gamma)} (1 \times 10^{-7})"
    )


PAPER = r"""Costs 5\$, % and $\pi_c = \pi_d$ is a comment
$\pi_\theta = \arg\max J$ and $\gamma_{23} = \{\gamma_2, \gamma_3\}$ and $x$:
\begin{align}
  \pi_a &\equiv \pi_b \\
    &\quad \triangleleft \pi_c, \quad (3.1) \\
  \nabla\phi &= \begin{pmatrix} 1 \\ 2 \end{pmatrix} \\
  \pi_e &= \pi_a \tag{5}
\end{align} $unclosed \[ \pi_x = \pi_y
"""


def test_definitions_in_a_paper() -> None:
    found, others = definitions_in(PAPER)
    assert [(equation.number, equation.of_controller, equation.source.places[0][0]) for equation in found] == [
        ("", False, 2),
        ("3.1", True, 3),
        ("5", True, 6),
    ]
    assert parse_definition(found[1].source)[1] == parse_expression("π_b ◁ π_c")
    assert others == 3


def test_other_sets_in_a_paper_define_no_resources() -> None:
    others = r"$S = \{1, 2\}$, $X=\{x_1, \dots, x_n\}$, $f = \langle u, v\rangle$"
    quoted = r"\begin{verbatim}$\gamma_1=\{\gamma_2\}$\end{verbatim}"
    found, passed_over = definitions_in(rf"{others} {quoted} $\alpha = \{{\gamma_1, \gamma_2\}}$, $\Gamma = \{{1\}}$")
    assert [equation.source.text[:6] for equation in found] == [r"\alpha", r"\Gamma"]
    assert passed_over == 3


def test_long_papers_take_no_longer_a_row() -> None:
    rows, blanks = "a &= b\\\\\n" * 20_000, " " * 60_000
    begun = time.process_time()
    definitions_in(rf"\begin{{align}}{rows}\end{{align}} \[{blanks}a = b\]")
    assert time.process_time() - begun < 10.0  # of squares it would be minutes


TOKEN = re.compile(r"\\[A-Za-z]+|\\.|[A-Za-z0-9]+|.", re.DOTALL)
FORMULAS = [*(latex for latex, *_ in DEFINITIONS), *(latex for latex, _ in SPELLINGS)]
TOKENS = [*TOKEN.findall("".join(FORMULAS)), *"{}^_$%&#~|()<>,.=\n\t\\é", "\\frac", "\\begin", "10^{-3}", "\\\\"]


def _mutated(chance: random.Random) -> str:
    tokens = TOKEN.findall(chance.choice(FORMULAS))
    for _ in range(chance.choice((1, 1, 2, 3, 5))):
        first, last = sorted(chance.randrange(len(tokens) + 1) for _ in range(2))
        match chance.randrange(4):
            case 0:
                del tokens[first : first + 1]
            case 1:
                tokens.insert(first, chance.choice(TOKENS))
            case 2:
                tokens[first:first] = tokens[first:last]
            case _:
                tokens[first:last] = chance.choices(TOKENS, k=3)
    return "".join(tokens)


def test_mutated_formulas_are_read_or_refused_at_a_place_in_them() -> None:
    chance = random.Random(16)
    parse_expression("π_a")
    for _ in range(300):
        text, began = _mutated(chance), time.process_time()
        lines = text.split("\n")
        try:
            parse_definition(text)
        except DiagnosticError as error:
            for fault in error.diagnostics:
                assert fault.span is not None
                assert fault.hint
                assert (1, 1) <= (fault.span.line, fault.span.column) < (fault.span.end_line, fault.span.end_column)
                assert fault.span.end_column <= len(lines[fault.span.end_line - 1]) + 2
        assert time.process_time() - began < 1.0, text
