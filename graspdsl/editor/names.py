"""The names in the formulas of a spec: what each is a name of, where it stands, and where it is defined."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator
from dataclasses import dataclass

from graspdsl.diagnostics import Span
from graspdsl.editor.sheet import Formula, Place, Sheet
from graspdsl.notation.names import canonical
from graspdsl.notation.tree import (
    Abbreviation,
    Controller,
    Expression,
    Head,
    Name,
    Reference,
    Resources,
    ResourceSet,
    ScaledSensor,
    SubjectTo,
    Then,
    Transform,
    Vector,
    Virtual,
)
from graspdsl.places.document import Path

POTENTIAL, EFFECTOR, SENSOR = "potential", "effector transform", "sensor transform"
CONTROLLER, RESOURCE, PARAMETER = "controller", "resource", "parameter"
WORD = re.compile(r"[^\W\d_]\w*")
_HEADS = {"π": CONTROLLER, "φ": POTENTIAL, "τ": EFFECTOR, "σ": SENSOR}


@dataclass(frozen=True, slots=True)
class Use:
    """A name where it stands. ``what``: a potential, a controller, a resource, a parameter and so on, as the constants
    of this module have it, or empty where the formula cannot be read and the name does not tell.

    ``entry``: the path of the controller whose own parameter it is, else (); ``defines``: whether it is defined here.
    """

    what: str
    name: str
    span: Span
    path: Path
    entry: Path = ()
    defines: bool = False

    def is_at(self, place: Place) -> bool:
        """Whether a place is in the name or at its end."""
        span = self.span
        return (span.line, span.column) <= place <= (span.end_line, span.end_column)

    def is_of(self, other: Use) -> bool:
        """Whether the two are of one thing."""
        return (self.what, self.name, self.entry) == (other.what, other.name, other.entry)


def uses_in(sheet: Sheet) -> tuple[Use, ...]:
    """Every name of a spec's formulas and of what they may name; of formulas that cannot be read only the words."""
    found = [use for formula in sheet.formulas for use in _of_formula(formula)]
    declared = [(RESOURCE, entry.key, entry.path) for entry in sheet.declared.resources]
    for name in sheet.spec.parameters or {}:
        path: Path = ("parameters", name)
        declared.append((PARAMETER, sheet.document.key_source_text(path), path))
    found += [Use(w, canonical(key.text), key.span(0, len(key.text)), path, defines=True) for w, key, path in declared]
    return tuple(found)


def use_at(sheet: Sheet, place: Place) -> Use | None:
    """The name at a place."""
    return next((use for use in uses_in(sheet) if use.is_at(place)), None)


def definition_of(sheet: Sheet, use: Use) -> Use | None:
    """Where a name is defined in the spec itself."""
    return next((other for other in uses_in(sheet) if other.defines and _meant(use, other)), None)


def _meant(use: Use, other: Use) -> bool:
    return use.is_of(other) or (not use.what and (use.name, use.entry) == (other.name, other.entry))


def _of_formula(formula: Formula) -> Iterator[Use]:
    if formula.tree is None:
        for word in WORD.finditer(formula.text.text):
            name = canonical(word.group())
            yield _use(_HEADS.get(name[0], ""), name, formula.text.span(*word.span()), formula)
        return
    named = _in_head(formula.tree) if isinstance(formula.tree, Head) else names_in(formula.tree)
    for what, tree in named:
        yield _use(what, tree.text, tree.span, formula)


def _use(what: str, name: str, span: Span, formula: Formula) -> Use:
    own = name in formula.bound
    defines = formula.start == "head" and (what == CONTROLLER or own)
    return Use(what, name, span, formula.path, formula.entry if own else (), defines)


def _in_head(head: Head) -> Iterator[tuple[str, Name]]:
    yield CONTROLLER, head.name
    for name in (*head.effector, *head.sensor):
        yield RESOURCE, name
    if head.reference is not None:
        yield PARAMETER, head.reference


def names_in(tree: Expression | Resources) -> Iterator[tuple[str, Name]]:
    """The names in a tree, each with what it is a name of."""
    match tree:
        case Controller():
            yield POTENTIAL, tree.potential
            yield from _in_transform(EFFECTOR, tree.effector)
            yield from _in_transform(SENSOR, tree.sensor)
            yield from _in_reference(tree.reference)
        case Abbreviation():
            yield CONTROLLER, tree.name
            yield from _in_each((*tree.effector, *tree.sensor))
            yield from _in_reference(tree.reference)
        case SubjectTo(parts) | Then(parts):
            yield from _in_each(parts)
        case Virtual(members) | ResourceSet(members):
            yield from _in_each(members)
        case Name():
            yield RESOURCE, tree


def _in_each(trees: Iterable[Expression | Resources]) -> Iterator[tuple[str, Name]]:
    for tree in trees:
        yield from names_in(tree)


def _in_transform(what: str, tree: Transform) -> Iterator[tuple[str, Name]]:
    yield what, tree.name
    yield from names_in(tree.resources)


def _in_reference(tree: Reference | None) -> Iterator[tuple[str, Name]]:
    match tree:
        case None | Vector():
            return
        case Name():
            yield PARAMETER, tree
        case ScaledSensor(factor, sensor):
            if isinstance(factor, Name):
                yield PARAMETER, factor
            yield from _in_transform(SENSOR, sensor)
        case _:
            yield from names_in(tree)
