"""From Lark's tree to the syntax tree: names get their canonical spelling, every node its place."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from graspdsl.diagnostics import Span
from graspdsl.notation.fault import Fault, Placed
from graspdsl.notation.names import canonical
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

if TYPE_CHECKING:
    from lark import Token, Tree


class Builder:
    """Builds the nodes of one text; ``faults`` collects what the grammar cannot see (numbers out of range)."""

    def __init__(self, source: Placed) -> None:
        self.source = source
        self.faults: list[Fault] = []

    def expression(self, node: Tree[Token]) -> Expression:
        """The node of a controller, an abbreviation or a composition."""
        match node.data:
            case "then":
                return Then(tuple(self.expression(step) for step in _branches(node)), self._span(node))
            case "subject_to":
                return SubjectTo(tuple(self.expression(term) for term in _branches(node)), self._span(node))
            case "controller":
                return self._controller(node)
            case _:
                return self._abbreviation(node)

    def head(self, node: Tree[Token]) -> Head:
        """The node of a definition's left side."""
        name = self._name(_leaf(node))
        match _branches(node):
            case [effector, sensor, *reference]:
                return Head(
                    name,
                    tuple(self._name(_leaf(parameter)) for parameter in _branches(effector)),
                    tuple(self._name(_leaf(parameter)) for parameter in _branches(sensor)),
                    self._name(_leaf(reference[0])) if reference else None,
                    self._span(node),
                )
            case _:
                return Head(name, span=self._span(node))

    def resources(self, node: Tree[Token]) -> Resources:
        """The node of a resource, a virtual contact or a set."""
        if node.data == "resource_set":
            return ResourceSet(tuple(self._resource(member) for member in _branches(node)), self._span(node))
        return self._resource(node)

    def _resource(self, node: Tree[Token]) -> Resource:
        if node.data == "virtual":
            return Virtual(tuple(self._resource(member) for member in _branches(node)), self._span(node))
        return self._name(_leaf(node))

    def _controller(self, node: Tree[Token]) -> Controller:
        potential, effector, sensor, *reference = _branches(node)
        return Controller(
            self._name(_leaf(potential)),
            self._transform(effector),
            self._transform(sensor),
            self._reference(reference[0]) if reference else None,
            self._span(node),
        )

    def _transform(self, node: Tree[Token]) -> Transform:
        return Transform(self._name(_leaf(node)), self.resources(_branches(node)[0]), self._span(node))

    def _abbreviation(self, node: Tree[Token]) -> Abbreviation:
        name = self._name(_leaf(node))
        match _branches(node):
            case [effector, sensor, *reference]:
                return Abbreviation(
                    name,
                    tuple(self.resources(argument) for argument in _branches(effector)),
                    tuple(self.resources(argument) for argument in _branches(sensor)),
                    self._reference(reference[0]) if reference else None,
                    self._span(node),
                )
            case _:
                return Abbreviation(name, span=self._span(node))

    def _reference(self, node: Tree[Token]) -> Reference:
        match node.data:
            case "name":
                return self._name(_leaf(node))
            case "vector":
                return Vector(tuple(self._number(leaf) for leaf in _leaves(node)), self._span(node))
            case "scaled":
                return self._scaled(node)
            case _:
                return self.expression(node)

    def _scaled(self, node: Tree[Token]) -> ScaledSensor:
        *factors, sensor = _branches(node)
        numbers = _leaves(node)
        factor: float | Name | None = None
        if numbers:
            factor = self._number(numbers[0])
        elif factors:
            factor = self._name(_leaf(factors[0]))
        return ScaledSensor(factor, self._transform(sensor), self._span(node))

    def _name(self, leaf: Token) -> Name:
        start, end = _extent(leaf)
        return Name(canonical(leaf.value), self.source.span(start, end))

    def _number(self, leaf: Token) -> float:
        value = float(leaf.value)
        if not math.isfinite(value):
            start, end = _extent(leaf)
            self.faults.append(
                Fault(start, end, "number-too-large", "this number is too large", "numbers reach up to about 1.8e308")
            )
        return value

    def _span(self, node: Tree[Token]) -> Span:
        return self.source.span(node.meta.start_pos, node.meta.end_pos)


def _branches(node: Tree[Token]) -> list[Tree[Token]]:
    return [child for child in node.children if not isinstance(child, str)]


def _leaves(node: Tree[Token]) -> list[Token]:
    return [child for child in node.children if isinstance(child, str)]


def _leaf(node: Tree[Token]) -> Token:
    return _leaves(node)[0]


def _extent(leaf: Token) -> tuple[int, int]:
    start = leaf.start_pos or 0
    return start, start + len(leaf.value)
