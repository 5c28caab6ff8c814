"""The type checker: names, spaces and resources of an expression, and the graph they make."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from copy import copy
from dataclasses import replace
from typing import TypeVar

from graspdsl.basis.effectors import EFFECTORS, Effector
from graspdsl.basis.entry import cited
from graspdsl.basis.potentials import POTENTIALS, Potential
from graspdsl.basis.prelude import Definition
from graspdsl.basis.resources import ContactSet, JointSet
from graspdsl.basis.sensors import SENSORS, Sensor
from graspdsl.basis.spaces import GradientSpace
from graspdsl.compiler.complaints import Complaints
from graspdsl.compiler.definitions import TOO_LARGE, Bindings, abbreviations_in, expanded, in_order_of_use
from graspdsl.compiler.graph import Composition, ControllerGraph, ControllerNode
from graspdsl.compiler.references import ReferenceCheck
from graspdsl.compiler.resources import ResourceTable
from graspdsl.diagnostics import DiagnosticError, Fix, known_names_hint, likely, listed
from graspdsl.notation import tree as syntax
from graspdsl.notation.printer import to_unicode
from graspdsl.plugins.kinds import with_offered

T = TypeVar("T")
OF_A_HELD_OBJECT = frozenset({"centre_of_mass", "weight"})
# Of the chapter's own.
_SLIPS = {"π_gs": "did you mean π_gx? Sec. 4.5 prints π_gs for it once"}
MOST_DEPTH = 100
MOST_PARTS = 2000


class Checker:
    """Checks expressions against the basis, the definitions and the resources of one spec.

    Complaints are collected, not raised; a faulty expression has no graph.
    """

    def __init__(
        self,
        resources: ResourceTable,
        definitions: Mapping[str, Definition],
        parameters: Mapping[str, tuple[float, ...] | None],
        complaints: Complaints,
    ) -> None:
        self.complaints, self.definitions = complaints, dict(definitions)
        self._resources, self._parameters = resources, parameters
        self._references = ReferenceCheck(self, parameters)
        self._open: list[str] = []
        self._depth = self._visits = 0
        self._spaces: dict[str, GradientSpace | None] = {}

    def check_definitions(self) -> None:
        """Check each of the spec's own definitions, used or not; a faulty one has no body any more.

        What their parameters stand for is known only where they are used: faults of that are found there.
        """
        doubtful: set[str] = set()  # those that stand on a faulty one: how large they are is not known
        for definition in in_order_of_use(self.definitions):
            name, before = definition.head.name.text, len(self.complaints.found)
            if definition.in_prelude or definition.body is None:
                continue
            self.complaints.about(definition.path)
            self._over_anything(definition).stages(definition.body)
            if not doubtful.isdisjoint(used.name.text for used in abbreviations_in(definition.body)):
                doubtful.add(name)
                self.complaints.found[before:] = [f for f in self.complaints.found[before:] if f.code != TOO_LARGE]
            if self.complaints.of_definition(before):
                doubtful.add(name)
            if name in doubtful:
                self.definitions[name] = replace(definition, body=None)

    def _over_anything(self, definition: Definition) -> Checker:
        """The checker of a definition's body, where nothing is known of its parameters."""
        names = definition.parameters
        checker = copy(self)
        checker._resources = self._resources.with_unknown(names)
        checker._parameters = {**self._parameters, **dict.fromkeys(names)}
        checker._references = ReferenceCheck(checker, checker._parameters)
        checker._open = [definition.head.name.text]
        return checker

    def stages(self, tree: syntax.Expression) -> tuple[ControllerGraph, ...] | None:
        """The graphs of ``a then b then …``, one for a formula without ``then``."""
        if isinstance(tree, syntax.Abbreviation):
            return self._within(tree, self.stages)
        if isinstance(tree, syntax.Then):
            parts = [self.stages(step) for step in tree.steps]
            complete = [part for part in parts if part is not None]
            return tuple(graph for part in complete for graph in part) if len(complete) == len(parts) else None
        graph = self.expression(tree)
        return None if graph is None else (graph,)

    def expression(self, tree: syntax.Expression) -> ControllerGraph | None:
        """The graph of an expression that is one controller at every tick."""
        if self._too_large(tree):
            return None
        self._depth += 1
        self._visits += 1
        graph = self._graph(tree)
        self._depth -= 1
        return graph

    def _too_large(self, tree: syntax.Expression) -> bool:
        """Whether definitions of definitions make more of a formula than can be checked; guards time and memory."""
        depth = len(self._open) + self._depth
        self._visits = self._visits if depth else 0
        if self._visits < MOST_PARTS and depth < MOST_DEPTH:
            return False
        self.complaints.error(
            TOO_LARGE,
            f"written out, this formula has more than {MOST_PARTS} parts, or parts nested deeper than {MOST_DEPTH}",
            tree.span,
            "use fewer definitions of definitions",
        )
        return True

    def _graph(self, tree: syntax.Expression) -> ControllerGraph | None:
        match tree:
            case syntax.Controller():
                return self._controller(tree)
            case syntax.SubjectTo():
                return self._composition(tree)
            case syntax.Abbreviation():
                return self._within(tree, self.expression)
            case syntax.Then():
                self.complaints.error(
                    "then-inside",
                    "'then' joins whole controllers; it cannot stand inside ◁ or a reference",
                    tree.span,
                    "put 'then' outermost: a ◁ b then c",
                )
                return None

    # --- ◁ ----------------------------------------------------------------------------------------------------

    def _composition(self, tree: syntax.SubjectTo) -> Composition | None:
        graphs = [self.expression(term) for term in tree.terms]
        complete = [graph for graph in graphs if graph is not None]
        known = [(term, space) for term in tree.terms if (space := self.space(term)) is not None]
        if len({space for _, space in known}) > 1:
            found = "; ".join(f"{to_unicode(term)} is in {space.value}" for term, space in known)
            self.complaints.error(
                "mixed-spaces",
                f"◁ joins gradients of one space only: {found}",
                tree.span,
                "use effector transforms of one space; a controller in x becomes a reference of φ_p, as in π_s|Γ Γ (…)",
            )
            return None
        return Composition(tuple(complete)) if len(complete) == len(graphs) else None

    def space(self, tree: syntax.Expression) -> GradientSpace | None:
        """The gradient space of an expression, faults elsewhere in it apart; None where it has not one and no other."""
        match tree:
            case syntax.Controller(potential, effector):
                moved, moving = EFFECTORS.get(effector.name.text), POTENTIALS.get(potential.text)
                fits = moved is not None and moving is not None and moved.symbol in moving.effectors
                return moved.gradient_space if fits and moved is not None else None
            case syntax.SubjectTo(terms):
                spaces = {self.space(term) for term in terms}
                return spaces.pop() if len(spaces) == 1 else None
            case syntax.Abbreviation(name):
                definition = self.definitions.get(name.text)
                if name.text not in self._spaces:
                    self._spaces[name.text] = None  # of what is defined by itself
                    if definition is not None and definition.body is not None:
                        self._spaces[name.text] = self.space(definition.body)
                return self._spaces[name.text]
        return None

    # --- abbreviations ------------------------------------------------------------------------------------------

    def _within(self, tree: syntax.Abbreviation, check: Callable[[syntax.Expression], T]) -> T | None:
        """What a check makes of that for which an abbreviation stands."""
        body = self._expansion(tree)
        if body is None:
            return None
        before = len(self.complaints.found)
        self._open.append(tree.name.text)
        found = check(body)
        self._open.pop()
        self.complaints.of_use(before)
        return found

    def _expansion(self, tree: syntax.Abbreviation) -> syntax.Expression | None:
        """What an abbreviation stands for, with its arguments in place."""
        name = tree.name.text
        definition = self.definitions.get(name)
        if definition is None:
            known = with_offered("controllers", self.definitions)
            slip = _SLIPS.get(name)
            hint = slip or known_names_hint(name, known, "controllers")
            fixes = () if slip else likely(name, known, tree.name.span)
            self.complaints.error("unknown-controller", f"there is no controller {name}", tree.name.span, hint, fixes)
            return None
        if name in self._open:
            cycle = " → ".join([*self._open[self._open.index(name) :], name])
            self.complaints.error(
                "definition-cycle", f"{name} is defined by itself: {cycle}", tree.span, "define it by other controllers"
            )
            return None
        if self._too_large(tree):
            return None
        bindings = self._bindings(tree, definition)
        if bindings is None or definition.body is None:
            return None
        try:
            return expanded(definition.body, bindings, tree.span)
        except DiagnosticError as error:
            self.complaints.take(error)
            return None

    def _bindings(self, tree: syntax.Abbreviation, definition: Definition) -> Bindings | None:
        head = definition.head
        if len(tree.effector) != len(head.effector) or len(tree.sensor) != len(head.sensor):
            self.complaints.error(
                "wrong-arguments",
                f"{to_unicode(replace(tree, reference=None))} does not fit {to_unicode(replace(head, reference=None))}",
                tree.span,
                f"{head.name.text} takes {len(head.effector)} effector and {len(head.sensor)} sensor resources",
            )
            return None
        if (tree.reference is None) != (head.reference is None):
            missing = tree.reference is None
            self.complaints.error(
                "missing-reference" if missing else "unexpected-reference",
                f"{head.name.text} {'needs a' if missing else 'takes no'} reference",
                tree.span,
                f"it is defined as {to_unicode(head)}",
            )
            return None
        bindings: dict[str, syntax.Resources | syntax.Reference] = {}
        for formal, given in zip((*head.effector, *head.sensor), (*tree.effector, *tree.sensor), strict=True):
            if formal.text in bindings and not self._same(bindings[formal.text], given, definition):
                return None
            bindings.setdefault(formal.text, given)
        if head.reference is not None and tree.reference is not None:
            bindings[head.reference.text] = tree.reference
        return bindings

    def _same(
        self, first: syntax.Resources | syntax.Reference, second: syntax.Resources, definition: Definition
    ) -> bool:
        """Whether two arguments for one parameter are the same resources, as Eq. 4.18 and 4.24 ask for."""
        assert isinstance(first, syntax.Name | syntax.Virtual | syntax.ResourceSet)
        if first == second:
            return True
        one, other = self._resources.resolve_any(first), self._resources.resolve_any(second)
        if one is None or other is None or one.same_as(other):
            return True
        name = definition.head.name.text
        self.complaints.error(
            "resources-differ",
            f"{name} needs the same resources for effector and sensor"
            f"{f' ({cited(definition.equation)})' if definition.equation else ''}, "
            f"found {to_unicode(first)} and {to_unicode(second)}",
            second.span,
            f"write {name}|{to_unicode(first)} {to_unicode(first)}",
            [Fix(second.span, to_unicode(first))],
        )
        return False

    # --- one controller -------------------------------------------------------------------------------------------

    def _controller(self, tree: syntax.Controller) -> ControllerNode | None:
        potential = self._known(tree.potential, POTENTIALS, "potential")
        effector = self._known(tree.effector.name, EFFECTORS, "effector transform")
        sensor = self.sensor(tree.sensor.name)
        over_joints = sensor is not None and sensor.over_joints
        moved = self._moved(tree.effector.resources, over_joints)
        sensed = self.sensed(tree.sensor.resources, sensor)
        if potential is None:
            self._references.names(tree.reference)
            return None
        fits = self._fits(tree, potential, effector, sensor)
        sound, reference = self._references.reference(tree.reference, potential, sensed, tree.span)
        if not (fits and sound) or effector is None or sensor is None or moved is None or sensed is None:
            return None
        if sensor.per_contact and not (moved.same_as(sensed) or self._turn_alike(sensor)):
            self.complaints.error(
                "resources-differ",
                f"{potential.symbol} servoes each contact: effector and sensor need the same resources, found "
                f"{moved.label} and {sensed.label}",
                tree.sensor.resources.span,
                f"write {sensor.symbol}({moved.label})",
                [Fix(tree.sensor.span, f"{sensor.symbol}({moved.label})")],
            )
            return None
        rotating = effector.gradient_space is GradientSpace.ROTATION
        if rotating and isinstance(sensed, ContactSet) and not sensed.has_gravity:
            self.complaints.warning(
                "zero-gradient",
                f"contacts that turn together do not change {sensor.symbol}: without γ_g the gradient is always zero",
                tree.sensor.resources.span,
                "put γ_g among the sensor's resources (Eq. 4.41)",
            )
        if sensor.per_contact and moved.same_as(sensed):
            moved = sensed  # the same resources, in the order of the sensor's rows
        label = to_unicode(syntax.Controller(tree.potential, tree.effector, tree.sensor))
        return ControllerNode(label, potential, effector, moved, sensor, sensed, reference)

    def _fits(
        self, tree: syntax.Controller, potential: Potential, effector: Effector | None, sensor: Sensor | None
    ) -> bool:
        fits = True
        if sensor is not None and sensor.symbol not in potential.sensors:
            self.complaints.error(
                "wrong-sensor",
                f"{potential.symbol} works on {potential.space.about}; {sensor.symbol} senses {sensor.space.about}",
                tree.sensor.span,
                f"use {listed(potential.sensors, 'or')}",
                [Fix(tree.sensor.name.span, symbol) for symbol in potential.sensors],
            )
            fits = False
        if effector is not None and effector.symbol not in potential.effectors:
            self.complaints.error(
                "wrong-effector",
                f"{effector.symbol} is no effector transform of {potential.symbol}: it moves {effector.about}",
                tree.effector.span,
                f"use {listed(potential.effectors, 'or')}",
                [Fix(tree.effector.name.span, symbol) for symbol in potential.effectors],
            )
            fits = False
        return fits

    def sensor(self, name: syntax.Name) -> Sensor | None:
        """The sensor transform of a name."""
        return self._known(name, SENSORS, "sensor transform")

    def sensed(self, resources: syntax.Resources, sensor: Sensor | None) -> ContactSet | JointSet | None:
        """The resources of a sensor transform, without gravity where it feels none."""
        found = self._resolved(resources, sensor is not None and sensor.over_joints)
        if sensor is not None and not self._resources.senses_gravity and not OF_A_HELD_OBJECT.isdisjoint(sensor.reads):
            message = f"{sensor.symbol} cannot be sensed: weight and centre of mass are known only of a held object"
            hint = "add 'held: true' to the object, or use another sensor transform"
            self.complaints.error("not-sensed", message, resources.span, hint)
            return None
        if sensor is None or sensor.feels_gravity or not isinstance(found, ContactSet):
            return found
        contacts = found.without_gravity
        if not contacts.members:
            message = f"{sensor.symbol} senses nothing of γ_g"
            self.complaints.error("gravity-not-sensed", message, resources.span, "name a contact beside it")
            return None
        return contacts

    def _turn_alike(self, sensor: Sensor) -> bool:
        """Whether what is sensed of one contact is served by moving any: a held object turns with all of them."""
        return sensor.turns_alike and self._resources.senses_gravity

    def _resolved(self, resources: syntax.Resources, over_joints: bool) -> ContactSet | JointSet | None:
        return self._resources.resolve_joints(resources) if over_joints else self._resources.resolve(resources)

    def _moved(self, resources: syntax.Resources, over_joints: bool) -> ContactSet | JointSet | None:
        """The resources of an effector transform: gravity is not among what can be moved (Sec. 4.4.2)."""
        if self._resources.has_gravity(resources):
            self.complaints.error(
                "gravity-effector",
                "γ_g cannot be moved: gravity has no place in an effector transform",
                resources.span,
                "put γ_g in the sensor resources only",
            )
            return None
        return self._resolved(resources, over_joints)

    def _known(self, name: syntax.Name, table: Mapping[str, T], what: str) -> T | None:
        found = table.get(name.text)
        if found is None:
            symbol = what.split()[0]
            known = with_offered(f"{symbol}s", table)
            hint, fixes = known_names_hint(name.text, known, f"{what}s"), likely(name.text, known, name.span)
            self.complaints.error(f"unknown-{symbol}", f"there is no {what} {name.text}", name.span, hint, fixes)
        return found
