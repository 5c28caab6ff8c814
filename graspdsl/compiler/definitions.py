"""Named controllers: the prelude's and the spec's own, and how a use of one becomes what it stands for."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import TypeVar

from graspdsl.basis.entry import cited
from graspdsl.basis.prelude import Definition, prelude
from graspdsl.compiler.complaints import Complaints, span_of
from graspdsl.compiler.declarations import Declaration
from graspdsl.diagnostics import Diagnostic, DiagnosticError, Span
from graspdsl.notation.parser import parse_definition, parse_head
from graspdsl.notation.printer import to_unicode
from graspdsl.notation.tree import (
    Abbreviation,
    Controller,
    Expression,
    Head,
    Name,
    Reference,
    Resource,
    Resources,
    ResourceSet,
    ScaledSensor,
    SubjectTo,
    Then,
    Transform,
    Vector,
    Virtual,
)


def definitions_with(
    entries: Sequence[Declaration], complaints: Complaints, of_others: Mapping[str, Definition]
) -> dict[str, Definition]:
    """The prelude, definitions of other packages and the spec's own; complains about faulty, repeated and overriding
    ones."""
    known = {**prelude(), **of_others}
    for entry in entries:
        complaints.about(entry.path)
        head: Head | None = None
        body: Expression | None = None
        try:
            head = parse_head(entry.key)
        except DiagnosticError as error:
            complaints.take(error)
        try:
            defined, body = parse_definition(entry.value)
        except DiagnosticError as error:
            defined = None
            complaints.take(error)
        if head is None:
            continue
        if defined is not None and head == Head(defined.name):
            head = defined
        elif defined not in (None, head):
            complaints.error(
                "other-head",
                f"the definition is of {to_unicode(defined)}, its key is {to_unicode(head)}",
                defined.span,
                f"let the key be {defined.name.text}, or leave out the left side here",
            )
        name = head.name.text
        if name in known:
            where = f"in the prelude ({cited(known[name].equation)})" if known[name].in_prelude else "above"
            where = f"by {known[name].by}" if known[name].by else where
            complaints.error(
                "controller-redefined",
                f"{name} is defined already, {where}",
                span_of(entry.key),
                "choose another name",
            )
            continue
        known[name] = Definition(head, body, entry.equation, entry.about, path=entry.path)
    return known


def used_in(tree: Expression | None, definitions: Mapping[str, Definition]) -> tuple[Definition, ...]:
    """The definitions that an expression stands on, those in definitions too, in the order in which they are met."""
    found: dict[str, Definition] = {}
    waiting = [tree]
    while waiting:
        names = dict.fromkeys(used.name.text for used in abbreviations_in(waiting.pop(0)))
        new = [definitions[name] for name in names if name in definitions and name not in found]
        found.update({definition.head.name.text: definition for definition in new})
        waiting += [definition.body for definition in new]
    return tuple(found.values())


def in_order_of_use(definitions: Mapping[str, Definition]) -> Iterator[Definition]:
    """Definitions after those that they use, as far as they do not use each other in a circle."""
    done: set[str] = set()
    begun: set[str] = set()
    waiting = list(definitions)[::-1]
    while waiting:
        name = waiting[-1]
        if name not in begun:
            begun.add(name)
            used = dict.fromkeys(each.name.text for each in abbreviations_in(definitions[name].body))
            waiting += [other for other in used if other in definitions and other not in begun]
            continue
        waiting.pop()
        if name not in done:
            done.add(name)
            yield definitions[name]


def abbreviations_in(tree: Expression | Reference | Resources | None) -> Iterator[Abbreviation]:
    """The uses of named controllers in an expression, in the order of the formula."""
    match tree:
        case Controller():
            yield from abbreviations_in(tree.reference)
        case Abbreviation():
            yield tree
            yield from abbreviations_in(tree.reference)
        case SubjectTo(parts) | Then(parts):
            for part in parts:
                yield from abbreviations_in(part)


Bindings = Mapping[str, Resources | Reference]
Tree = TypeVar("Tree", Name, Vector)


MOST_MEMBERS = 100
TOO_LARGE = "formula-too-large"


def expanded(body: Expression, bindings: Bindings, span: Span) -> Expression:
    """The body of a definition with arguments for its parameters; what the body itself wrote gets the span.

    Raises DiagnosticError for arguments that cannot stand where the body puts them.
    """
    return _Expansion(bindings, span).expression(body)


class _Expansion:
    def __init__(self, bindings: Bindings, span: Span) -> None:
        self._bindings, self._span = bindings, span

    def expression(self, tree: Expression) -> Expression:
        match tree:
            case Controller():
                return Controller(
                    self._placed(tree.potential),
                    self._transform(tree.effector),
                    self._transform(tree.sensor),
                    self._reference(tree.reference),
                    self._span,
                )
            case Abbreviation():
                return Abbreviation(
                    self._placed(tree.name),
                    tuple(self._resources(argument) for argument in tree.effector),
                    tuple(self._resources(argument) for argument in tree.sensor),
                    self._reference(tree.reference),
                    self._span,
                )
            case SubjectTo(terms):
                return SubjectTo(tuple(self.expression(term) for term in terms), self._span)
            case Then(steps):
                return Then(tuple(self.expression(step) for step in steps), self._span)

    def _placed(self, tree: Tree) -> Tree:
        return replace(tree, span=self._span)

    def _transform(self, tree: Transform) -> Transform:
        return Transform(self._placed(tree.name), self._resources(tree.resources), self._span)

    def _reference(self, tree: Reference | None) -> Reference | None:
        match tree:
            case None:
                return None
            case Name(text):
                bound = self._bindings.get(text)
                return self._placed(tree) if bound is None or isinstance(bound, Virtual | ResourceSet) else bound
            case Vector():
                return self._placed(tree)
            case ScaledSensor(factor, sensor):
                return ScaledSensor(self._factor(factor), self._transform(sensor), self._span)
        return self.expression(tree)

    def _factor(self, factor: float | Name | None) -> float | Name | None:
        if not isinstance(factor, Name):
            return factor
        match self._bindings.get(factor.text):
            case None | Virtual() | ResourceSet():
                return self._placed(factor)
            case Name() as name:
                return name
            case Vector((value,)):
                return value
            case given:
                message = f"{factor.text} scales a sensor and must be one number"
                hint = "give one number, or a parameter that is one"
                raise DiagnosticError([Diagnostic("wrong-size", message, given.span, hint)])

    def _resources(self, tree: Resources) -> Resources:
        if isinstance(tree, ResourceSet):
            return ResourceSet(self._members(tree.members), self._span)
        if isinstance(tree, Virtual):
            return self._virtual(tree)
        bound = self._bindings.get(tree.text)
        return bound if isinstance(bound, Name | Virtual | ResourceSet) else self._placed(tree)

    def _virtual(self, tree: Virtual) -> Virtual:
        return Virtual(self._members(tree.members), self._span)

    def _members(self, members: Sequence[Resource]) -> tuple[Resource, ...]:
        """Members with their arguments; a set given for a member brings its own members along."""
        found: list[Resource] = []
        for member in members:
            given = self._resources(member)
            found += given.members if isinstance(given, ResourceSet) else [given]
        if sum(map(_contacts, found)) > MOST_MEMBERS:
            message = f"with its arguments in place, a set would have more than {MOST_MEMBERS} members"
            raise DiagnosticError([Diagnostic(TOO_LARGE, message, self._span, "name each contact once")])
        return tuple(found)


def _contacts(tree: Resource) -> int:
    return sum(map(_contacts, tree.members)) if isinstance(tree, Virtual) else 1
