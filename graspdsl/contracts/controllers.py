"""The contract of named controllers, those of the prelude and of other packages."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from itertools import product

import numpy as np

from graspdsl.basis.prelude import Definition, prelude
from graspdsl.compiler.check import Checker
from graspdsl.compiler.complaints import Complaints
from graspdsl.compiler.declarations import DEFAULT_WORLD, default_scene
from graspdsl.compiler.definitions import Bindings, expanded
from graspdsl.compiler.phase import CheckedPhase, grasp_of
from graspdsl.compiler.pipeline import Pipeline
from graspdsl.compiler.resources import ResourceTable
from graspdsl.compiler.settings import Target
from graspdsl.contracts.rule import Breach, contract
from graspdsl.contracts.scene import CONTACTS, JOINTS, WITH_GRAVITY, faulty_ticks, observations
from graspdsl.diagnostics import Diagnostic, DiagnosticError, has_errors
from graspdsl.hands.descriptions import robot
from graspdsl.notation.parser import parse_expression, parse_head, parse_resources
from graspdsl.notation.printer import to_ascii, to_unicode
from graspdsl.notation.tree import (
    NOWHERE,
    Abbreviation,
    Controller,
    Expression,
    Name,
    Reference,
    Resources,
    ScaledSensor,
    SubjectTo,
    Then,
    Vector,
)
from graspdsl.spec.program import Control
from graspdsl.worlds.kinds import WORLDS

ROBOT = robot("barrett", "gantry")
LONGEST = 120  # characters of a line in a list
NEXT_TO_NOTHING = 1e-12  # m or rad


@dataclass(frozen=True, slots=True)
class Written:
    """A controller of a file, its formula, and the definitions that this may name, the prelude's and its file's."""

    definition: Definition
    body: Expression
    known: Mapping[str, Definition]

    @property
    def name(self) -> str:
        """The name that formulas know it by."""
        return self.definition.head.name.text


def written(definitions: Mapping[str, Definition]) -> list[Written]:
    """The controllers of one file, each beside the others."""
    known = {**prelude(), **definitions}
    return [Written(found, found.body, known) for found in definitions.values() if found.body is not None]


def notation(entry: Written) -> Iterator[Breach]:
    """Head and formula are the same after they were printed and read, in Unicode and in ASCII."""
    head, body = entry.definition.head, entry.body
    for printed in (to_unicode, to_ascii):
        if parse_head(printed(head)) != head:
            yield (
                f"its head {to_unicode(head)} is read as {to_unicode(parse_head(printed(head)))}",
                "choose other names",
            )
        if parse_expression(printed(body)) != body:
            yield f"{to_unicode(body)} is read otherwise in another spelling", "choose other names"


def told(entry: Written) -> Iterator[Breach]:
    """Where a controller comes from, and in one line what it is for."""
    if not entry.definition.equation:
        yield "where it comes from is not said", "add 'equation', a number or a source"
    about = entry.definition.about
    if not about:
        yield "what it is for is not said", "add 'about', in one line"
    elif "\n" in about or len(about) > LONGEST or about.endswith("."):
        yield f"its line for lists is {about!r}", f"write about in one line of at most {LONGEST}, without a full stop"


def parameters(entry: Written) -> Iterator[Breach]:
    """Each name in the head has its part in the formula."""
    used = {name.text for name in _names(entry.body)}
    for name in dict.fromkeys(entry.definition.parameters):
        if name not in used:
            yield f"{name} in its head has no part in its formula", f"leave {name} out"


def formula(entry: Written) -> Iterator[Breach]:
    """The formula has no fault, whatever its parameters stand for."""
    complaints = Complaints()
    definition = replace(entry.definition, in_prelude=False)
    free = dict.fromkeys(name.text for name in _numbers(entry.body))
    checker = _checker({**entry.known, entry.name: definition}, complaints, {**default_scene().parameters, **free})
    checker.check_definitions()
    yield from _told(complaints.found)


def use(entry: Written) -> Iterator[Breach]:
    """There is a use of it that is checked without an error, over contacts or joints."""
    found = _best_use(entry)
    if isinstance(found, list) and not any(formula(entry)):
        yield from _told(found)


def tick(entry: Written) -> Iterator[Breach]:
    """A tick of that use commands a displacement, finite and of the right shape."""
    found = _best_use(entry)
    if not isinstance(found, list):
        for pipeline in _pipelines(found):
            yield from faulty_ticks(pipeline, ROBOT, found.label)


def moves(entry: Written) -> Iterator[Breach]:
    """And some tick moves something."""
    found = _best_use(entry)
    if not isinstance(found, list):
        for pipeline in _pipelines(found):
            ticks = [pipeline.ticks(seen).displacement for seen in observations(ROBOT)]
            if np.abs(ticks).max() < NEXT_TO_NOTHING:
                yield f"{found.label} moves nothing", "see whether its gradient is always zero"


RULES = contract(notation, told, parameters, formula, use, tick, moves, name=lambda entry: entry.name, wording=(told,))


def _told(found: list[Diagnostic]) -> Iterator[Breach]:
    yield from ((fault.message, fault.hint or "") for fault in found if has_errors([fault]))


def _checker(
    definitions: Mapping[str, Definition],
    complaints: Complaints,
    numbers: Mapping[str, tuple[float, ...] | None] | None = None,
) -> Checker:
    table = ResourceTable(default_scene().resources, ROBOT, complaints, senses_gravity=True)
    return Checker(table, definitions, numbers or default_scene().parameters, complaints)


def _names(tree: Expression | Reference) -> Iterator[Name]:
    """The names in a formula that a head may have, as often as they are there."""
    match tree:
        case Name():
            yield tree
        case ScaledSensor(factor, sensor):
            yield from [factor] if isinstance(factor, Name) else []
            yield from _members(sensor.resources)
        case Controller():
            yield from _members(tree.effector.resources)
            yield from _members(tree.sensor.resources)
            yield from _names(tree.reference) if tree.reference else ()
        case Abbreviation():
            for resources in (*tree.effector, *tree.sensor):
                yield from _members(resources)
            yield from _names(tree.reference) if tree.reference else ()
        case SubjectTo(parts) | Then(parts):
            for part in parts:
                yield from _names(part)


def _members(resources: object) -> Iterator[Name]:
    if isinstance(resources, Name):
        yield resources
    for member in getattr(resources, "members", ()):
        yield from _members(member)


def _numbers(tree: Expression | Reference | None) -> Iterator[Name]:
    """The names in a formula that stand for numbers."""
    match tree:
        case Name():
            yield tree
        case ScaledSensor(Name() as factor, _):
            yield factor
        case Controller() | Abbreviation():
            yield from _numbers(tree.reference)
        case SubjectTo(parts) | Then(parts):
            for part in parts:
                yield from _numbers(part)


def _choices(entry: Written) -> Iterator[Bindings]:
    """What the parameters of a head, and the numbers in its formula, may stand for."""
    head = entry.definition.head
    contacts, joints, gravity = (parse_resources(text) for text in (CONTACTS, JOINTS, WITH_GRAVITY))
    moved = {name.text for name in head.effector}
    names: dict[str, list[Resources | Reference]] = {}
    for name in (*head.effector, *head.sensor):
        names[name.text] = [contacts, joints] if name.text in moved else [contacts, gravity, joints]
    count = len(ROBOT.joint_sets[JOINTS])
    vectors = [Vector(tuple((place + 1) / 10 for place in range(size))) for size in (9, count, 1)]
    for name in _numbers(entry.body):
        names.setdefault(name.text, [*vectors])
    for chosen in product(*names.values()):
        yield dict(zip(names, chosen, strict=True))


def _best_use(entry: Written) -> CheckedPhase | list[Diagnostic]:
    """The use with the fewest complaints; only these where it has errors."""
    best: tuple[int, int] | None = None
    found: CheckedPhase | list[Diagnostic] = []
    for bindings in _choices(entry):
        complaints = Complaints()
        phase = _used(entry, bindings, complaints)
        errors = sum(has_errors([fault]) for fault in complaints.found)
        rank = (errors, len(complaints.found))
        if best is None or rank < best:
            best, found = rank, complaints.found if phase is None or errors else phase
        if best == (0, 0):
            break
    return found


def _used(entry: Written, bindings: Bindings, complaints: Complaints) -> CheckedPhase | None:
    try:
        tree = expanded(entry.body, bindings, NOWHERE)
    except DiagnosticError as error:
        complaints.take(error)
        return None
    stages = _checker(entry.known, complaints).stages(tree)
    return None if stages is None else CheckedPhase(tree, stages, grasp_of(stages, ROBOT))


def _pipelines(phase: CheckedPhase) -> tuple[Pipeline, ...]:
    return phase.pipelines(Target(ROBOT, WORLDS[DEFAULT_WORLD], Control(), phase.holds))
