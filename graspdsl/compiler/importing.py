"""A spec out of a paper: its definitions as controllers and resources, around them what makes a spec."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import yaml

from graspdsl.basis.prelude import prelude
from graspdsl.compiler.assumed import assumed_around
from graspdsl.compiler.program import examine
from graspdsl.compiler.surroundings import USUAL, Surroundings
from graspdsl.diagnostics import Diagnostic, DiagnosticError, Severity, Span, has_errors, in_reading_order
from graspdsl.notation.papers import Equation, definitions_in
from graspdsl.notation.parser import parse_definition, parse_expression, parse_head, parse_resource_definition
from graspdsl.notation.printer import to_unicode
from graspdsl.notation.tree import Expression, Head
from graspdsl.places.wording import slug

SUFFIX = "_paper"  # of a name that the prelude has
_MOST_TRIED = 4  # controllers, of which one is to be run


@dataclass(frozen=True, slots=True)
class _Found:
    """A definition of a controller, and where its sides stand."""

    head: Head
    body: Expression
    number: str
    span: Span
    body_span: Span


def spec_of_paper(text: str, name: str) -> tuple[str, tuple[Diagnostic, ...], int]:
    """The text of a spec of a LaTeX document's definitions, warnings about these, and how many formulas are none.

    ``name``: the document's file. Raises DiagnosticError with every fault of a definition, each with its place in the
    document, and where it defines nothing.
    """
    equations, others = definitions_in(text)
    controllers, resources, where, warnings = _read(equations)
    if not equations:
        message = "there is no definition of a controller or of resources in this file"
        hint = r"a definition is an equation such as \pi_{mine}|_{\Gamma}^{\Gamma} \equiv \phi_{fr}|_{…}^{…}, in $…$"
        raise DiagnosticError([Diagnostic("nothing-defined", message, hint=hint)])
    renamed = _renamed(controllers)
    around = replace(USUAL, resources={**(USUAL.resources or {}), **resources})
    for found in renamed:
        around = _without(assumed_around(found.body, around), around, found.head)
    faults: list[Diagnostic] = []
    for run in (*renamed[: -_MOST_TRIED - 1 : -1], None):
        for displacement in ("sliding", "probing"):
            written, places = _written(name, renamed, around, run, displacement)
            examined = examine(written, name)
            if not has_errors(examined.diagnostics):
                return written, warnings, others
            places = {**_lines_of(written, where), **places}
            faults = [_placed(fault, places) for fault in examined.diagnostics if fault.severity is Severity.ERROR]
    raise DiagnosticError(in_reading_order(faults))


def _lines_of(written: str, resources: Mapping[str, Span]) -> dict[int, Span]:
    """Where resources are defined, by the lines of the spec that declare them."""
    keys = {line.partition(":")[0].strip(): number for number, line in enumerate(written.splitlines(), 1)}
    return {keys[name]: span for name, span in resources.items()}


def _read(
    equations: Sequence[Equation],
) -> tuple[list[_Found], dict[str, str], dict[str, Span], tuple[Diagnostic, ...]]:
    """The definitions of controllers and of resources, with their places; of two of one name the first counts."""
    controllers: dict[str, _Found] = {}
    resources: dict[str, str] = {}
    where: dict[str, Span] = {}
    faults: list[Diagnostic] = []
    warnings: list[Diagnostic] = []
    for equation in equations:
        try:
            if equation.of_controller:
                head, body = parse_definition(equation.source)
                assert head is not None
                found = _Found(head, body, equation.number, head.span, body.span)
                known = controllers.setdefault(head.name.text, found)
                differs, label = (known.head, known.body) != (head, body), head.name.text
            else:
                named, meaning = parse_resource_definition(equation.source)
                assert named is not None
                differs = resources.setdefault(named.text, to_unicode(meaning)) != to_unicode(meaning)
                label = named.text
                where.setdefault(label, named.span.to(meaning.span))
        except DiagnosticError as error:
            faults += error.diagnostics
            continue
        if differs:
            message = f"{label} is defined before, and otherwise; this is passed over"
            span = equation.source.span(0, len(equation.source.text))
            warnings.append(Diagnostic("defined-twice", message, span, severity=Severity.WARNING))
    if faults:
        raise DiagnosticError(in_reading_order(faults))
    return list(controllers.values()), resources, where, tuple(warnings)


def _renamed(controllers: Sequence[_Found]) -> list[_Found]:
    """The definitions with names of their own where the prelude has the name, in their uses as well."""
    taken = [found.head.name.text for found in controllers if found.head.name.text in prelude()]

    def again(text: str) -> str:
        return re.sub(rf"(?<!\w)(?:{'|'.join(taken)})(?!\w)", rf"\g<0>{SUFFIX}", text) if taken else text

    return [
        replace(
            found, head=parse_head(again(to_unicode(found.head))), body=parse_expression(again(to_unicode(found.body)))
        )
        for found in controllers
    ]


def _without(assumed: Surroundings, before: Surroundings, head: Head) -> Surroundings:
    """What is assumed around a definition, but for its parameters."""
    reference = () if head.reference is None else (head.reference,)
    names = {name.text for name in (*head.effector, *head.sensor, *reference)}
    resources, parameters = assumed.resources or {}, assumed.parameters
    kept = before.resources or {}
    return replace(
        assumed,
        resources={name: value for name, value in resources.items() if name in kept or name not in names},
        parameters={
            name: value for name, value in parameters.items() if name in before.parameters or name not in names
        },
    )


def _written(
    name: str, controllers: Sequence[_Found], around: Surroundings, run: _Found | None, displacement: str
) -> tuple[str, Mapping[int, Span]]:
    """The spec's text, and where that which stands on one of its lines is defined."""
    if run is not None:
        around = assumed_around(run.body, around)
        formula = to_unicode(run.head)
    else:
        formula = "π_close|Γ Γ"
    rows = [
        "graspdsl: 1",
        f"name: {_scalar(slug(Path(name).stem) or 'paper')}",
        f"about: {_scalar(f'The definitions in {name}.')}",
        "",
    ]
    rows += ["scene: {world: bullet, hand: barrett, mount: gantry, object: towel-roll}"]
    rows += [f"control: {{displacement: {displacement}}}"] if displacement != "sliding" else []
    rows += ["", "resources:", *(f"  {key}: {_scalar(value)}" for key, value in (around.resources or {}).items())]
    rows += ["", "parameters:"]
    rows += [
        f"  {key}: {value if isinstance(value, list) else _number(value)}" for key, value in around.parameters.items()
    ]
    places: dict[int, Span] = {}
    rows += ["", "controllers:"] if controllers else []
    for found in controllers:
        original = found.head.name.text.removesuffix(SUFFIX)
        notes = [f"({found.number})" if found.number else ""]
        notes += [f"{original} is in the prelude already"] if original != found.head.name.text else []
        said = "; ".join(filter(None, notes))
        rows += [f"  # {said}"] if said else []
        rows += [f"  {to_unicode(found.head)}:", f"    is: {to_unicode(found.body)}"]
        places |= {len(rows) - 1: found.span, len(rows): found.body_span}
        if found.number:
            rows += [f"    equation: {_scalar(found.number, quoted=True)}"]
    rows += ["", "program:", f"  - run: {formula}", "    until: {contact: all}", "    limit: 30.0", ""]
    rows += ["trials: {count: 1, seed: 1}"]
    return "\n".join(rows) + "\n", places


def _scalar(text: str, *, quoted: bool = False) -> str:
    style = '"' if quoted or text[:1] in "{<" else None
    return yaml.safe_dump(text, allow_unicode=True, default_style=style, width=10_000).split("\n")[0]


def _number(value: object) -> str:
    (number,) = value if isinstance(value, tuple) else (value,)
    return str(number)


def _placed(fault: Diagnostic, places: Mapping[int, Span]) -> Diagnostic:
    """A fault of the spec as one of the document."""
    return replace(fault, span=places.get(fault.span.line) if fault.span else None)
