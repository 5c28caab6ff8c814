"""The grammar of formulas as rules to read: each with its EBNF, from the grammar that the parser itself is made of."""

from __future__ import annotations

import re
from dataclasses import dataclass
from functools import cache
from typing import TYPE_CHECKING

from graspdsl.notation.syntax import TEXT

if TYPE_CHECKING:
    from lark import Token, Tree

_COMMENT = re.compile(r"//\s?(.*)")
_RULED = re.compile(r"-{3,}")  # a heading of a part of the grammar

# Formulas, and what each shows; in the scene in which formulas outside a spec stand.
EXAMPLES = {
    "π_close|Γ Γ": "an abbreviation: effector resources, then sensor resources",
    "φ_fr|τ_frx(Γ) σ_fr(Γ)": "a controller: a potential with its effector and its sensor transform",
    "φ_mr|τ_mrx(Γ) σ_mr(Γ) ◁ φ_fr|τ_frx(Γ) σ_fr(Γ)": "moment subject to force: the rightmost has the highest priority",
    "φ_fr|τ_frx(Γ) σ_fr(Γ) then φ_mr|τ_mrx(Γ) σ_mr(Γ)": "force to convergence, then moment",
    "φ_w|τ_wx(γ1) σ_w(Γ)": "one contact moves, the residual is that of all",
    "φ_p|τ_p(γ1) σ_p(γ1) (0.1, 0, 0.3)": "a reference of numbers, in the unit of the potential's task space",
    "φ_f|τ_f(Γ) σ_f(Γ) (κ_f σ_n(Γ))": "a reference of a sensor transform, times a parameter",
    "φ_f|τ_f(Γ) σ_f(Γ) (0.5 σ_n(Γ))": "the same, times a number",
    "π_s|Γ Γ (π_gx|Γ Γ)": "a reference of a controller: the position that its gradient leads to",
    "φ_p|τ_p(Γ) σ_p(Γ) (π_gx|Γ Γ) ◁ π_close|Γ Γ": "controllers and abbreviations mixed",
    "π_close|{γ1, γ2} {γ1, γ2}": "a set of contacts",
    "π_close|{γ1, <γ2, γ3>} {γ1, <γ2, γ3>}": "a set of a contact and a virtual contact",
    "π_rgθ|Γ {γ1, <γ2, γ3>, γ_g}": "gravity among what is sensed",
    "φ_k|τ_k(all) σ_k(flexion)": "sets of joints, by their names",
    "π_sq|(Γ, all) (Γ, flexion) (π_gx|Γ Γ)": "several sets on each side, in brackets",
}


@dataclass(frozen=True, slots=True)
class Rule:
    """A rule: its name, the comment that stands over it, and what it is, as Lark reads it. A word has capitals."""

    name: str
    about: str
    body: Tree[Token] | Token

    @property
    def is_word(self) -> bool:
        """Whether it is of characters, without blanks between them, rather than of words."""
        return self.name.isupper()

    @property
    def ebnf(self) -> str:
        """What it is, in EBNF: ``chain (THEN chain)*``; what stands between slashes is a regular expression."""
        return ebnf(self.body)


@cache
def rules() -> tuple[Rule, ...]:
    """The rules of the grammar in their order, those of words last."""
    from lark import Lark

    reader = Lark.open_from_package(
        "lark", "lark.lark", ("grammars",), parser="lalr", propagate_positions=True, maybe_placeholders=False
    )
    text = TEXT.read_text(encoding="utf-8")
    lines = text.split("\n")
    found = []
    for item in reader.parse(text).children:
        if not isinstance(item, str) and item.data in ("rule", "token"):
            name, *_, body = item.children
            found.append(Rule(shown(str(name)), _over(lines, item.meta.line), body))
    return tuple(found)


def _over(lines: list[str], line: int) -> str:
    """The comment that ends right above a line, counted from 1."""
    said: list[str] = []
    for above in reversed(lines[: line - 1]):
        comment = _COMMENT.fullmatch(above)
        if comment is None or _RULED.search(comment[1]):
            break
        said.insert(0, comment[1])
    return " ".join(said)


def shown(name: str) -> str:
    """The name of a rule, without the signs that tell Lark what to keep of it."""
    return name.lstrip("?!_")


def ebnf(part: Tree[Token] | Token) -> str:
    """A part of a rule in EBNF."""
    if isinstance(part, str):
        return shown(part)
    pieces = [ebnf(child) for child in part.children]
    match part.data:
        case "expansions":
            return " | ".join(pieces)
        case "expansion":
            return " ".join(_bracketed(child, piece) for child, piece in zip(part.children, pieces, strict=True))
        case "expr":
            inner, sign = pieces
            single = isinstance(part.children[0], str) or part.children[0].data in ("name", "literal")
            return f"{inner}{sign}" if single else f"({inner}){sign}"
        case "maybe":
            single = isinstance(part.children[0], str) or part.children[0].data in ("name", "literal")
            return f"{pieces[0]}?" if single else f"({pieces[0]})?"
        case _:  # what gives a name to a node of the tree says so second
            return pieces[0]


def _bracketed(part: Tree[Token] | Token, text: str) -> str:
    return f"({text})" if not isinstance(part, str) and part.data == "expansions" else text
