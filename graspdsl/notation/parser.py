"""From text to syntax tree: expressions, the heads of definitions, and resources."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING

from graspdsl.diagnostics import DiagnosticError, SourceText, in_reading_order
from graspdsl.notation.alphabet import foreign_characters, latex
from graspdsl.notation.brackets import bracket_faults, outer_terms
from graspdsl.notation.builder import Builder
from graspdsl.notation.characters import fold
from graspdsl.notation.expectation import syntax_fault
from graspdsl.notation.fault import Fault
from graspdsl.notation.operators import operator_faults
from graspdsl.notation.situation import Situation
from graspdsl.notation.syntax import Halt, Start, read
from graspdsl.notation.tree import Expression, Head, Resources

if TYPE_CHECKING:
    from lark import Token, Tree

MAXIMUM_LENGTH = 10_000
MAXIMUM_FAULTS = 20


def parse_expression(text: SourceText | str) -> Expression:
    """The tree of a controller expression such as ``π_s|Γ Γ (π_gx|Γ Γ)``.

    Raises DiagnosticError with every mistake found: in characters, in brackets, and one in each of the terms that
    ◁ and ``then`` join at the outermost level.
    """
    source, node = _syntax(text, "expression")
    builder = Builder(source)
    expression = builder.expression(node)
    if builder.faults:
        raise _error(builder.faults, source)
    return expression


def parse_head(text: SourceText | str) -> Head:
    """The tree of a definition's left side, ``π_s|Γ_m Γ_m (x_ref)`` or ``π_mine``; raises DiagnosticError."""
    source, node = _syntax(text, "head")
    return Builder(source).head(node)


def parse_resources(text: SourceText | str) -> Resources:
    """The tree of a resource, a virtual contact or a set, ``{γ1, <γ2, γ3>}``; raises DiagnosticError."""
    source, node = _syntax(text, "resources")
    return Builder(source).resources(node)


def _syntax(text: SourceText | str, start: Start) -> tuple[SourceText, Tree[Token]]:
    source = _limited(text)
    written = source.text
    folded = fold(written)
    whole = latex(folded, written)
    if whole:
        raise _error([whole], source)
    brackets = bracket_faults(folded)
    operators = operator_faults(folded, written, brackets) if start == "expression" else []
    faults = operators + _outside(operators, foreign_characters(folded, written) + brackets)
    if not faults:
        node = read(folded, start)
        if not isinstance(node, Halt):
            return source, node
        faults = [syntax_fault(Situation.of(node, folded, written, start))]
    if start == "expression" and not _outside(operators, brackets):
        faults += _faults_of_terms(folded, written, faults)
    raise _error(faults, source)


def _limited(text: SourceText | str) -> SourceText:
    length = len(text if isinstance(text, str) else text.text)
    if isinstance(text, str):
        # Only so much of a text needs places as a formula may be long.
        text = SourceText.of(text[: MAXIMUM_LENGTH + 1])
    if length > MAXIMUM_LENGTH:
        message = f"this formula has {length} characters; at most {MAXIMUM_LENGTH} are read"
        hint = "define parts of the formula under names of their own"
        raise _error([Fault(MAXIMUM_LENGTH, MAXIMUM_LENGTH + 1, "too-long", message, hint)], text)
    return text


def _faults_of_terms(folded: str, written: str, known: list[Fault]) -> list[Fault]:
    """The first grammar fault of each outermost term in which no fault is known yet."""
    faults: list[Fault] = []
    for begin, end in outer_terms(folded):
        if len(faults) == MAXIMUM_FAULTS:
            break
        if not folded[begin:end].strip() or any(begin <= fault.start <= end for fault in known):
            continue
        halt = read(folded[begin:end], "expression")
        if isinstance(halt, Halt):
            term = Situation.of(halt, folded[begin:end], written[begin:end], "expression")
            faults.append(syntax_fault(term).shifted(begin))
    return faults


def _outside(known: list[Fault], others: list[Fault]) -> list[Fault]:
    """The other faults, without those about something of which a fault is known."""
    return [other for other in others if not any(fault.start <= other.start < fault.end for fault in known)]


def _error(faults: Iterable[Fault], source: SourceText) -> DiagnosticError:
    return DiagnosticError(in_reading_order(fault.placed(source) for fault in faults)[:MAXIMUM_FAULTS])
