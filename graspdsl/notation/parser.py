"""From text to syntax tree: expressions, the heads of definitions, and resources."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable
from typing import TYPE_CHECKING, TypeVar

from graspdsl.diagnostics import Diagnostic, DiagnosticError, SourceText, in_reading_order
from graspdsl.notation.alphabet import foreign_characters
from graspdsl.notation.brackets import bracket_faults, outer_terms
from graspdsl.notation.builder import Builder
from graspdsl.notation.fault import Fault, Placed
from graspdsl.notation.latex import reading_of
from graspdsl.notation.operators import operator_faults
from graspdsl.notation.printer import to_unicode
from graspdsl.notation.reading import Reading
from graspdsl.notation.syntax import Halt, Start, read
from graspdsl.notation.tree import Expression, Head, Name, Resources, ResourceSet, Virtual

if TYPE_CHECKING:
    from lark import Token, Tree

MAXIMUM_LENGTH = 10_000
MAXIMUM_FAULTS = 20

# Of two sides; a sign of an operator is another thing.
_DEFINES = re.compile(r"::?=|(?<![=<>])=(?![=<>])|[≡≜≔]")
L = TypeVar("L")
R = TypeVar("R")


def parse_expression(text: SourceText | str) -> Expression:
    """The tree of a controller expression such as ``π_s|Γ Γ (π_gx|Γ Γ)``.

    Raises DiagnosticError with every mistake found: in characters, in brackets, and one in each of the terms that
    ◁ and ``then`` join at the outermost level.
    """
    return _expression(_reading(text))


def parse_head(text: SourceText | str) -> Head:
    """The tree of a definition's left side, ``π_s|Γ_m Γ_m (x_ref)`` or ``π_mine``; raises DiagnosticError."""
    return _head(_reading(text))


def parse_resources(text: SourceText | str) -> Resources:
    """The tree of a resource, a virtual contact or a set, ``{γ1, <γ2, γ3>}``; raises DiagnosticError."""
    return _resources(_reading(text))


def parse_definition(text: SourceText | str) -> tuple[Head | None, Expression]:
    """The two sides of ``π_g|Γ Γ ≡ φ_mr|… ◁ φ_fr|…``; the left one is None of what is an expression alone.

    Raises DiagnosticError with the mistakes on both sides.
    """
    left, right = _sides(_reading(text))
    try:
        return _both(left, _head, lambda: _expression(right))
    except DiagnosticError as error:
        raise (_of_resources(left, right) or error) from None


def parse_resource_definition(text: SourceText | str) -> tuple[Name | None, Resources]:
    """The two sides of ``Γ = {γ1, γ2}``; the left one is None of what is a set alone, or another resource.

    A contact γ_… of which a set stands on the right is the virtual contact of its members, as Sec. 4.5.1 has it:
    ``\\gamma_{23} = \\{\\gamma_2, \\gamma_3\\}`` is <γ2, γ3>. Raises DiagnosticError.
    """
    return _resource_sides(*_sides(_reading(text)))


def _resource_sides(left: Reading | None, right: Reading) -> tuple[Name | None, Resources]:
    name, meaning = _both(left, _resource_name, lambda: _resources(right))
    if name is not None and name.text.startswith("γ") and isinstance(meaning, ResourceSet):
        meaning = Virtual(meaning.members, meaning.span)
    return name, meaning


def defines(text: str) -> bool:
    """Whether a text in plain spelling is a definition."""
    return _DEFINES.search(text) is not None


def _expression(reading: Reading) -> Expression:
    builder = Builder(reading)
    expression = builder.expression(_syntax(reading, "expression"))
    if builder.faults:
        raise _error(builder.faults, reading)
    return expression


def _head(reading: Reading) -> Head:
    return Builder(reading).head(_syntax(reading, "head"))


def _resources(reading: Reading) -> Resources:
    return Builder(reading).resources(_syntax(reading, "resources"))


def _resource_name(reading: Reading) -> Name:
    tree = _resources(reading)
    if isinstance(tree, Name):
        return tree
    message, hint = "only a name can be defined", "write a name on the left, Γ or γ23"
    raise _error([Fault(0, len(reading.text), "unexpected-sign", message, hint)], reading)


def _sides(reading: Reading) -> tuple[Reading | None, Reading]:
    """What is defined and what it stands for, of a definition; else all of it as the latter."""
    sign = _DEFINES.search(reading.text)
    if sign is None:
        return None, reading
    return reading.part(0, sign.start()), reading.part(sign.end(), len(reading.text))


def _both(left: Reading | None, read_left: Callable[[Reading], L], read_right: Callable[[], R]) -> tuple[L | None, R]:
    """Both sides of a definition, or the mistakes of both."""
    faults: list[Diagnostic] = []
    defined: L | None = None
    try:
        defined = None if left is None else read_left(left)
    except DiagnosticError as error:
        faults += error.diagnostics
    try:
        meaning = read_right()
    except DiagnosticError as error:
        raise DiagnosticError(in_reading_order([*faults, *error.diagnostics])[:MAXIMUM_FAULTS]) from None
    if faults:
        raise DiagnosticError(faults)
    return defined, meaning


def _of_resources(left: Reading | None, right: Reading) -> DiagnosticError | None:
    """The refusal of a definition that is one of resources, where a controller's was asked for."""
    try:
        name, meaning = _resource_sides(left, right)
    except DiagnosticError:
        return None
    if name is None:
        return None
    said = to_unicode(meaning)
    message = f"this defines resources, {name.text} = {said}, and no controller"
    hint = f'declare them in a spec, under resources: {name.text}: "{said}"'
    return DiagnosticError([Diagnostic("defines-resources", message, name.span.to(meaning.span), hint)])


def _reading(text: SourceText | str) -> Reading:
    source = _limited(text)
    reading, faults = reading_of(source)
    if faults:
        raise _error(faults, source)
    return reading


def _syntax(reading: Reading, start: Start) -> Tree[Token]:
    brackets = bracket_faults(reading.text)
    operators = operator_faults(reading, brackets) if start == "expression" else []
    faults = operators + _outside(operators, foreign_characters(reading) + brackets)
    if not faults:
        node = read(reading.text, start)
        if not isinstance(node, Halt):
            return node
        faults = [_fault_of(node, reading, start)]
    if start == "expression" and not _outside(operators, brackets):
        faults += _faults_of_terms(reading, faults)
    raise _error(faults, reading)


def _fault_of(halt: Halt, reading: Reading, start: Start) -> Fault:
    from graspdsl.notation.expectation import syntax_fault
    from graspdsl.notation.situation import Situation

    return syntax_fault(Situation.of(halt, reading, start))


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


def _faults_of_terms(reading: Reading, known: list[Fault]) -> list[Fault]:
    """The first grammar fault of each outermost term in which no fault is known yet."""
    faults: list[Fault] = []
    for begin, end in outer_terms(reading.text):
        if len(faults) == MAXIMUM_FAULTS:
            break
        term = reading.part(begin, end)
        if not term.text.strip() or any(begin <= fault.start <= end for fault in known):
            continue
        halt = read(term.text, "expression")
        if isinstance(halt, Halt):
            faults.append(_fault_of(halt, term, "expression").shifted(begin))
    return faults


def _outside(known: list[Fault], others: list[Fault]) -> list[Fault]:
    """The other faults, without those about something of which a fault is known."""
    return [other for other in others if not any(fault.start <= other.start < fault.end for fault in known)]


def _error(faults: Iterable[Fault], source: Placed) -> DiagnosticError:
    return DiagnosticError(in_reading_order(fault.placed(source) for fault in faults)[:MAXIMUM_FAULTS])
