"""What is said of the name or the key under a place, in Markdown."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path as FilePath

from graspdsl.basis.effectors import EFFECTORS
from graspdsl.basis.entry import cited
from graspdsl.basis.potentials import POTENTIALS
from graspdsl.basis.prelude import Definition
from graspdsl.basis.sensors import SENSORS
from graspdsl.basis.spaces import GradientSpace
from graspdsl.compiler.check import MOST_DEPTH, Checker
from graspdsl.compiler.complaints import Complaints
from graspdsl.compiler.definitions import abbreviations_in, expanded
from graspdsl.compiler.resources import GRAVITY, ResourceTable
from graspdsl.diagnostics import DiagnosticError, Span, listed
from graspdsl.editor.cursor import key_at
from graspdsl.editor.keys import described, model_of
from graspdsl.editor.names import CONTROLLER, EFFECTOR, PARAMETER, POTENTIAL, SENSOR, Use, definition_of, use_at
from graspdsl.editor.sheet import Formula, Place, Sheet, robot_of, sheet_of
from graspdsl.notation.printer import Printable, to_ascii, to_latex, to_unicode
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
    Vector,
    Virtual,
)
from graspdsl.places.files import with_plain_line_ends
from graspdsl.spec.models import Spec

LONGEST = 2000  # characters of a formula that is written out
Hover = tuple[str, Span]  # Markdown, and what it is about


def hover(text: str, place: Place, folder: FilePath) -> Hover | None:
    """What there is to say of what stands at a place; ``folder``: where the files are that the spec names."""
    text = with_plain_line_ends(text)
    model = model_of(text)
    sheet = sheet_of(text) if model is Spec else None
    use = use_at(sheet, place) if sheet is not None else None
    if sheet is not None and use is not None:
        said = "\n\n".join(_of_use(sheet, use, place, folder))
        return (said, use.span) if said else None
    key = key_at(text, place)
    said_of_key = None if key is None else described(model, key[0])
    if key is None or said_of_key is None:
        return None
    return said_of_key, Span(place[0], key[1], place[0], key[2])


def _of_use(sheet: Sheet, use: Use, place: Place, folder: FilePath) -> Iterator[str]:
    if use.entry:
        owner = to_unicode(next(f.tree for f in sheet.formulas if f.path == use.entry and isinstance(f.tree, Head)))
        yield f"**{use.name}**: what is given in this place where `{owner}` is used"
    elif use.what == CONTROLLER:
        yield from _of_controller(sheet, use, place)
    elif use.what == PARAMETER:
        value = (sheet.spec.parameters or {}).get(_written(sheet, use))
        yield f"**{use.name}**: a parameter" + (f", `{_number(value)}`" if value is not None else "")
    elif use.what in (POTENTIAL, EFFECTOR, SENSOR):
        yield from _of_entry(use)
    else:
        yield from _of_resource(sheet, use, folder)


def _written(sheet: Sheet, use: Use) -> str:
    found = definition_of(sheet, use)
    return str(found.path[-1]) if found is not None else use.name


def _number(value: float | tuple[float, ...]) -> str:
    return f"[{', '.join(f'{each:g}' for each in value)}]" if isinstance(value, tuple) else f"{value:g}"


def _of_entry(use: Use) -> Iterator[str]:
    """A potential or a transform of the basis."""
    if (potential := POTENTIALS.get(use.name)) is not None and use.what == POTENTIAL:
        yield f"**{use.name}** ({potential.source}): {potential.about}"
        yield f"task space: {potential.space.about}"
        moves = (f"`{name}` → {EFFECTORS[name].gradient_space.value}" for name in potential.effectors)
        yield f"senses by {listed(f'`{name}`' for name in potential.sensors)}; moves by {listed(moves, 'or')}"
    elif (effector := EFFECTORS.get(use.name)) is not None and use.what == EFFECTOR:
        yield f"**{use.name}** ({effector.source}): {effector.about}"
        yield f"gradient space {_space(effector.gradient_space)}"
    elif (sensor := SENSORS.get(use.name)) is not None:
        yield f"**{use.name}** ({sensor.source}): {sensor.about}"
        yield f"task space: {sensor.space.about}"


def _space(space: GradientSpace) -> str:
    return f"{space.value}: {space.about}"


def _of_resource(sheet: Sheet, use: Use, folder: FilePath) -> Iterator[str]:
    found = definition_of(sheet, use)
    if found is not None:
        value = (sheet.spec.resources or {}).get(str(found.path[-1]))
        yield f"**{use.name}** = `{value}`"
    elif use.name == GRAVITY:
        yield f"**{GRAVITY}** (Eq. 4.35 to 4.37): gravity, at the centre of mass of a held object; of sensors only"
    elif (robot := robot_of(sheet.spec, folder)) is not None and use.name in robot.joint_sets:
        yield f"**{use.name}**: joints of the robot: {listed(robot.joint_sets[use.name])}"


def _of_controller(sheet: Sheet, use: Use, place: Place) -> Iterator[str]:
    definition = sheet.definitions.get(use.name)
    if definition is None:
        return
    source = f" ({cited(definition.equation)})" if definition.equation else ""
    yield f"**{to_unicode(definition.head)}**{source}" + (f": {definition.about}" if definition.about else "")
    if definition.body is None:
        return
    formula = sheet.formula_at(place)
    used = _around(formula, use)
    body = definition.body if used is None else written_out(used, sheet.definitions)
    if body is not None:
        yield "stands for\n" + _spellings(body)
    spaces = [] if body is None else _spaces(body, sheet.definitions)
    if spaces:
        yield f"gradient space {'; then '.join(map(_space, spaces))}"
    tasks = dict.fromkeys(POTENTIALS[name].space.about for name in _potentials(body) if name in POTENTIALS)
    if tasks:
        yield f"task space: {listed(tasks)}"


def _spellings(tree: Printable) -> str:
    """A formula in every way of writing it."""
    rows = [to_unicode(tree), to_ascii(tree), to_latex(tree)]
    return "\n".join(["```", *rows, "```"])


def _around(formula: Formula | None, use: Use) -> Abbreviation | None:
    """The use of a controller with its resources and its reference; None in a head."""
    if formula is None or formula.tree is None or isinstance(formula.tree, Head):
        return None
    return next((tree for tree in abbreviations_in(formula.tree) if tree.name.span == use.span), None)


def _potentials(tree: Expression | Reference | Resources | None) -> Iterator[str]:
    match tree:
        case Controller():
            yield tree.potential.text
            yield from _potentials(tree.reference)
        case SubjectTo(parts) | Then(parts):
            for part in parts:
                yield from _potentials(part)


def _spaces(tree: Expression, definitions: Mapping[str, Definition]) -> list[GradientSpace]:
    """The gradient space of each stage."""
    nothing = Complaints()
    checker = Checker(ResourceTable((), None, nothing, senses_gravity=True), definitions, {}, nothing)
    found = [checker.space(step) for step in (tree.steps if isinstance(tree, Then) else (tree,))]
    return [space for space in found if space is not None]


def written_out(tree: Expression, definitions: Mapping[str, Definition]) -> Expression | None:
    """An expression without abbreviations, as far as they are defined; None where it would be too long to read."""
    try:
        whole = _WritingOut(definitions).expression(tree, MOST_DEPTH)
    except (_TooLongError, DiagnosticError):
        return None
    return whole if len(to_unicode(whole)) <= LONGEST else None


class _TooLongError(Exception):
    pass


class _WritingOut:
    def __init__(self, definitions: Mapping[str, Definition]) -> None:
        self._definitions, self._parts = definitions, 0

    def expression(self, tree: Expression, depth: int) -> Expression:
        self._parts += 1
        if self._parts > LONGEST or depth == 0:
            raise _TooLongError
        match tree:
            case Controller():
                reference = self._reference(tree.reference, depth)
                return Controller(tree.potential, tree.effector, tree.sensor, reference, tree.span)
            case SubjectTo(terms):
                return SubjectTo(tuple(self.expression(term, depth - 1) for term in terms), tree.span)
            case Then(steps):
                return Then(tuple(self.expression(step, depth - 1) for step in steps), tree.span)
            case Abbreviation():
                body = self._body(tree)
                return tree if body is None else self.expression(body, depth - 1)

    def _reference(self, tree: Reference | None, depth: int) -> Reference | None:
        return tree if isinstance(tree, None | Vector | Name | ScaledSensor) else self.expression(tree, depth - 1)

    def _body(self, tree: Abbreviation) -> Expression | None:
        """What an abbreviation stands for with its arguments in place; None where it does not fit its head."""
        definition = self._definitions.get(tree.name.text)
        if definition is None or definition.body is None:
            return None
        head, given = definition.head, (*tree.effector, *tree.sensor)
        formal = (*head.effector, *head.sensor)
        if len(given) != len(formal) or (tree.reference is None) != (head.reference is None):
            return None
        bindings: dict[str, Name | Virtual | ResourceSet | Reference] = {
            name.text: argument for name, argument in zip(formal, given, strict=True)
        }
        if head.reference is not None and tree.reference is not None:
            bindings[head.reference.text] = tree.reference
        return expanded(definition.body, bindings, tree.span)
