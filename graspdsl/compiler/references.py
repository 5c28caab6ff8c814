"""The check of references: does what a controller strives for lie in its task space, and is it of the right size."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Protocol

from graspdsl.basis.potentials import Potential
from graspdsl.basis.resources import ContactSet, JointSet
from graspdsl.basis.sensors import SENSORS, Sensor
from graspdsl.basis.spaces import GradientSpace
from graspdsl.compiler.complaints import Complaints
from graspdsl.compiler.graph import ControllerGraph, ControllerReference, Reference, SensorReference, VectorReference
from graspdsl.diagnostics import Diagnostic, Span, known_names_hint, likely, listed
from graspdsl.notation import tree as syntax
from graspdsl.notation.printer import to_unicode
from graspdsl.spec.models import LARGEST_PARAMETER

LARGEST_FORCE = 1000.0  # N


class ExpressionCheck(Protocol):
    """What the check of references asks of the checker of expressions, which a reference may hold."""

    complaints: Complaints

    def expression(self, tree: syntax.Expression) -> ControllerGraph | None:
        """The graph of an expression; None after a complaint."""
        ...

    def space(self, tree: syntax.Expression) -> GradientSpace | None:
        """The gradient space of an expression, as far as it is known."""
        ...

    def sensor(self, name: syntax.Name) -> Sensor | None:
        """The sensor transform of a name."""
        ...

    def sensed(self, resources: syntax.Resources, sensor: Sensor | None) -> ContactSet | JointSet | None:
        """The resources of a sensor transform."""
        ...


class ReferenceCheck:
    """Checks the references of one spec's controllers."""

    def __init__(self, checker: ExpressionCheck, parameters: Mapping[str, tuple[float, ...] | None]) -> None:
        self._checker, self._complaints, self._parameters = checker, checker.complaints, parameters

    def reference(
        self, tree: syntax.Reference | None, potential: Potential, resources: ContactSet | JointSet | None, span: Span
    ) -> tuple[bool, Reference | None]:
        """Whether the reference is sound, and what it is; over resources of which nothing is known it has no size."""
        if not potential.references:
            if tree is None:
                return True, None
            self._complaints.error(
                "unexpected-reference",
                f"{potential.symbol} strives for zero and takes no reference",
                tree.span,
                "leave the reference out",
            )
            return False, None
        if tree is None and potential.has_default_reference:
            return True, None
        found = self._found(tree, potential, resources, span)
        return found is not None, found

    def names(self, tree: syntax.Reference | None) -> None:
        """Complain about the names in a reference of which nothing else is known."""
        match tree:
            case None | syntax.Vector():
                pass
            case syntax.Name():
                self._parameter(tree)
            case syntax.ScaledSensor(factor, sensor):
                if isinstance(factor, syntax.Name):
                    self._parameter(factor)
                self._checker.sensed(sensor.resources, self._checker.sensor(sensor.name))
            case _:
                self._checker.expression(tree)

    def _found(
        self, tree: syntax.Reference | None, potential: Potential, resources: ContactSet | JointSet | None, span: Span
    ) -> Reference | None:
        match tree:
            case None:
                self._complaints.error(
                    "missing-reference",
                    f"{potential.symbol} needs a reference in its task space, {potential.space.about}",
                    span,
                    f"write it in brackets after the sensor transform: a vector, a parameter, or one made of "
                    f"{listed(potential.references, 'or')}",
                )
                return None
            case syntax.Vector(values):
                if not self._within(values, tree.span):
                    return None
                return self._vector(values, to_unicode_vector(values), potential, resources, tree.span)
            case syntax.Name(text):
                given = self._parameter(tree)
                return None if given is None else self._vector(given, text, potential, resources, tree.span)
            case syntax.ScaledSensor():
                return self._scaled(tree, potential, resources)
        return self._controller(tree, potential)

    def _parameter(self, name: syntax.Name) -> tuple[float, ...] | None:
        values = self._parameters.get(name.text)
        if name.text not in self._parameters:
            self._complaints.error(
                "missing-parameter",
                f"the parameter {name.text} is not given",
                name.span,
                f"add 'parameters: {{{name.text}: …}}'"
                if not self._parameters
                else known_names_hint(name.text, self._parameters, "parameters"),
                likely(name.text, self._parameters, name.span),
            )
        return values

    def _vector(
        self,
        values: tuple[float, ...],
        label: str,
        potential: Potential,
        resources: ContactSet | JointSet | None,
        span: Span,
    ) -> VectorReference | None:
        if resources is None:
            return None
        wanted = resources.size
        if len(values) != wanted:
            joints = isinstance(resources, JointSet)
            count = len(resources.joints) if isinstance(resources, JointSet) else len(resources.members)
            what = f"{count} {'joint' if joints else 'resource'}{'s' if count != 1 else ''}"
            self._complaints.error(
                "wrong-size",
                f"the reference of {potential.symbol} over {what} has {wanted} number{'s' if wanted != 1 else ''}, "
                f"{label} has {len(values)}",
                span,
                "give one number for each joint" if joints else "give x, y and z for each resource, in their order",
            )
            return None
        return VectorReference(label, values)

    def _scaled(
        self, tree: syntax.ScaledSensor, potential: Potential, resources: ContactSet | JointSet | None
    ) -> SensorReference | None:
        factor: float | None = 1.0
        if isinstance(tree.factor, syntax.Name):
            values = self._parameter(tree.factor)
            factor = values[0] if values and len(values) == 1 else None
            if values and len(values) != 1:
                self._complaints.error(
                    "wrong-size",
                    f"{tree.factor.text} scales a sensor and must be one number, it has {len(values)}",
                    tree.factor.span,
                    f"give one number, {tree.factor.text}: {values[0]:g}",
                )
        elif tree.factor is not None:
            factor = tree.factor if self._within((tree.factor,), tree.span) else None
        sensor = self._checker.sensor(tree.sensor.name)
        set_of_reference = self._checker.sensed(tree.sensor.resources, sensor)
        if sensor is None:
            return None
        if sensor.symbol not in potential.references:
            self._complaints.error(
                "wrong-reference",
                f"{potential.symbol} needs a reference in {potential.space.about}; {sensor.symbol} gives "
                f"{sensor.space.about}",
                tree.span,
                f"use {listed(potential.references, 'or')}",
            )
            return None
        if sensor.makes_forces and factor is not None and not 0.0 <= factor <= LARGEST_FORCE:
            self._pressed(tree, factor)
            return None
        if set_of_reference is None or resources is None or factor is None:
            return None
        if _rows(set_of_reference) != _rows(resources):
            self._complaints.error(
                "wrong-size",
                f"the reference is over {set_of_reference.label}, the controller over {resources.label}",
                tree.span,
                "use the same resources in both",
            )
            return None
        if set_of_reference.same_as(resources):
            set_of_reference = resources  # in the order of the sensor's rows
        parameter = tree.factor.text if isinstance(tree.factor, syntax.Name) else ""
        return SensorReference(to_unicode_scaled(tree), factor, SENSORS[sensor.symbol], set_of_reference, parameter)

    def _within(self, values: tuple[float, ...], span: Span) -> bool:
        """Whether numbers that a formula gives are no larger than those of parameters may be."""
        largest = max(values, key=abs)
        if abs(largest) <= LARGEST_PARAMETER:
            return True
        message = f"expected numbers from {-LARGEST_PARAMETER:g} to {LARGEST_PARAMETER:g}, found {largest:g}"
        self._complaints.error("out-of-range", message, span, "references are in N, m, rad or N·m")
        return False

    def _pressed(self, tree: syntax.ScaledSensor, force: float) -> None:
        message = f"contacts press along their normals with 0 to {LARGEST_FORCE:g} N, found {force:g}"
        hint = "normals point into the object: a force along them pushes, and contacts cannot pull"
        complaint = Diagnostic("out-of-range", message, tree.span, hint)
        if isinstance(tree.factor, syntax.Name):
            self._complaints.of_parameter(tree.factor.text, complaint)
        else:
            self._complaints.add(complaint)

    def _controller(self, tree: syntax.Expression, potential: Potential) -> ControllerReference | None:
        graph, space = self._checker.expression(tree), self._checker.space(tree)
        if space is not None and space is not potential.displaced_by:
            self._complaints.error(
                "wrong-reference",
                f"{potential.symbol} needs a reference in {potential.space.about}; this one is a gradient in "
                f"{space.value}, {space.about}",
                tree.span,
                f"use a controller whose gradient is in {potential.displaced_by.about}, as π_gx is"
                if potential.displaced_by
                else "no controller makes such a reference",
            )
            return None
        return None if graph is None else ControllerReference(graph)


def to_unicode_vector(values: tuple[float, ...]) -> str:
    """A vector as a formula writes it."""
    return f"({', '.join(f'{value:g}' for value in values)})"


def to_unicode_scaled(tree: syntax.ScaledSensor) -> str:
    """A scaled sensor as a formula writes it."""
    sensor = f"{tree.sensor.name.text}({to_unicode(tree.sensor.resources)})"
    match tree.factor:
        case None:
            return sensor
        case syntax.Name(text):
            return f"{text} {sensor}"
    return f"{tree.factor:g} {sensor}"


def _rows(resources: ContactSet | JointSet) -> list[int]:
    """What must agree for a reference over one set to fit a controller over another."""
    return [resources.size] if isinstance(resources, JointSet) else [len(m.weights) for m in resources.members]
