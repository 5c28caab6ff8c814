"""A whole spec, checked: every formula resolved, every fault of the file found at once."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from graspdsl.basis.resources import ContactSet
from graspdsl.basis.spaces import TaskSpace
from graspdsl.compiler.check import Checker
from graspdsl.compiler.complaints import Complaints, whole
from graspdsl.compiler.declarations import Declarations, PhaseEntry, declarations_of, default_scene
from graspdsl.compiler.definitions import definitions_with
from graspdsl.compiler.graph import ControllerGraph, controllers_in
from graspdsl.compiler.lowering import compile_controller
from graspdsl.compiler.pipeline import Pipeline
from graspdsl.compiler.resources import ResourceTable
from graspdsl.compiler.settings import Target
from graspdsl.diagnostics import Diagnostic, DiagnosticError, SourceText, has_errors, in_reading_order, known_names_hint
from graspdsl.hands.descriptions import Robot, hands, mounts, robot
from graspdsl.notation.names import canonical
from graspdsl.notation.parser import parse_expression
from graspdsl.notation.printer import to_unicode
from graspdsl.notation.tree import Expression
from graspdsl.objects.shapes import catalogue
from graspdsl.spec.constructing import Path
from graspdsl.spec.loading import read_spec
from graspdsl.spec.models import Spec
from graspdsl.spec.program import Control
from graspdsl.worlds.kinds import WORLDS, WorldKind


@dataclass(frozen=True, slots=True)
class CheckedPhase:
    """A phase of a program: its controllers, run one after the other, and the resources its residuals are of."""

    formula: Expression
    stages: tuple[ControllerGraph, ...]
    grasp: ContactSet

    @property
    def label(self) -> str:
        """The formula in Unicode."""
        return to_unicode(self.formula)


@dataclass(frozen=True, slots=True)
class Program:
    """A spec that is sound, with its robot, its world and its checked phases."""

    spec: Spec
    robot: Robot
    world: WorldKind
    phases: tuple[CheckedPhase, ...]

    def pipelines(self) -> tuple[tuple[Pipeline, ...], ...]:
        """The compiled stages of every phase."""
        target = Target(self.robot, self.world.rate, self.spec.control)
        return tuple(
            tuple(compile_controller(stage, phase.grasp, target) for stage in phase.stages) for phase in self.phases
        )


@dataclass(frozen=True, slots=True)
class Examination:
    """What became of a spec: its program when it has no errors, and every complaint."""

    program: Program | None
    diagnostics: tuple[Diagnostic, ...]


def examine(text: str, name: str, overrides: tuple[str, ...] = ()) -> Examination:
    """Check the text of a spec, faults of YAML, of values and of formulas all in one go."""
    try:
        document, spec, faults = read_spec(text, name, overrides)
    except DiagnosticError as error:
        return Examination(None, in_reading_order(error.diagnostics))
    complaints = Complaints(document)
    check = _ProgramCheck(declarations_of(document), complaints)
    phases = check.phases()
    diagnostics = in_reading_order([*faults, *complaints.found])
    if spec is None or check.robot is None or has_errors(diagnostics):
        return Examination(None, diagnostics)
    return Examination(Program(spec, check.robot, WORLDS[spec.scene.world], phases), diagnostics)


def program_of(text: str, name: str, overrides: tuple[str, ...] = ()) -> Program:
    """The program of a spec without errors; otherwise raises DiagnosticError."""
    examination = examine(text, name, overrides)
    if examination.program is None:
        raise DiagnosticError(examination.diagnostics)
    return examination.program


def examine_expression(text: str) -> tuple[CheckedPhase, Robot]:
    """Check an expression in the default scene. Raises DiagnosticError."""
    complaints = Complaints()
    check = _ProgramCheck(default_scene(), complaints)
    phase = check.phase(SourceText.of(text), ())
    if phase is None or check.robot is None:
        raise DiagnosticError(in_reading_order(complaints.found))
    return phase, check.robot


def default_target() -> Target:
    """The robot, rate and control settings of the default scene."""
    scene = default_scene()
    return Target(robot(scene.hand.text, scene.mount.text), WORLDS[scene.world.text].rate, Control())


class _ProgramCheck:
    def __init__(self, declarations: Declarations, complaints: Complaints) -> None:
        self._declarations, self._complaints = declarations, complaints
        self.robot = self._robot()
        self._named(("scene", "object"), declarations.object, catalogue(), "object")
        if self.robot is None:
            return
        self._parameters_once(declarations)
        definitions = definitions_with(declarations.controllers, complaints)
        table = ResourceTable(declarations.resources, self.robot, complaints)
        self._checker = Checker(table, definitions, declarations.parameters, complaints)

    def _robot(self) -> Robot | None:
        scene = self._declarations
        hand = self._named(("scene", "hand"), scene.hand, hands(), "hand")
        mount = scene.mount.text in mounts()  # the spec's model names the mounts there are
        return robot(scene.hand.text, scene.mount.text) if hand and mount else None

    def _named(self, path: Path, name: SourceText | None, known: Mapping[str, object], what: str) -> bool:
        if name is None or name.text in known:
            return True
        self._complaints.about(path)
        hint = known_names_hint(name.text, known, f"{what}s")
        self._complaints.error(f"unknown-{what}", f"there is no {what} {name.text!r}", whole(name), hint)
        return False

    def _parameters_once(self, declarations: Declarations) -> None:
        document, seen = declarations.document, set[str]()
        parameters = document.data.get("parameters") if document else None
        for key in parameters if document and isinstance(parameters, dict) else ():
            name = canonical(key)
            if name in seen:
                self._complaints.about(("parameters", key))
                span = document.key_span(("parameters", key)) if document else None
                message = f"{name} is declared twice, in two spellings"
                self._complaints.error("declared-twice", message, span, "keep one of them")
            seen.add(name)

    def phases(self) -> tuple[CheckedPhase, ...]:
        """The phases that are sound; complaints about the others."""
        if self.robot is None:
            return ()
        phases = []
        for entry in self._declarations.phases:
            phase = self.phase(entry.formula, entry.path)
            if phase is not None:
                self._fits_world(phase, entry)
                self._has_residuals(phase, entry)
                phases.append(phase)
        return tuple(phases)

    def phase(self, formula: SourceText, path: Path) -> CheckedPhase | None:
        """One formula, parsed and checked."""
        self._complaints.about(path)
        try:
            tree = parse_expression(formula)
        except DiagnosticError as error:
            self._complaints.take(error)
            return None
        stages = self._checker.stages(tree)
        return None if stages is None else CheckedPhase(tree, stages, _grasp(stages))

    def _fits_world(self, phase: CheckedPhase, entry: PhaseEntry) -> None:
        world = WORLDS.get(self._declarations.world.text)
        for stage in phase.stages:
            space = stage.gradient_space
            if world is not None and space not in world.spaces:
                can = ", ".join(f"{s.value}, {s.about}" for s in world.spaces)
                self._complaints.error(
                    "world-cannot-execute",
                    f"the {world.name} world cannot carry out a gradient in {space.value}, {space.about}",
                    whole(entry.formula),
                    f"it carries out {can}; make the controller the reference of one of those, as π_s|Γ Γ (…) does",
                )

    def _has_residuals(self, phase: CheckedPhase, entry: PhaseEntry) -> None:
        controlled = {node.potential.space for stage in phase.stages for node in controllers_in(stage)}
        wanted = {"force_residual": TaskSpace.NET_FORCE, "moment_residual": TaskSpace.NET_MOMENT}
        for key, space in wanted.items():
            if entry.conditions.get(key) is not None and space not in controlled and self._declarations.document:
                path: Path = (*entry.path[:-1], "until", key)
                self._complaints.about(path)
                self._complaints.warning(
                    "residual-not-controlled",
                    f"{key} is waited for, but no controller of this phase lowers it",
                    self._declarations.document.key_span(path),
                    "wait for something else, or run a controller with φ_fr and φ_mr",
                )


def _grasp(stages: tuple[ControllerGraph, ...]) -> ContactSet:
    """The resources whose residuals matter: those of the first residual sensor, else those the phase moves."""
    nodes = [node for stage in stages for node in controllers_in(stage)]
    residuals = (TaskSpace.NET_FORCE, TaskSpace.NET_MOMENT)
    return next(
        (node.sensor_resources for node in nodes if node.sensor.space in residuals), nodes[0].effector_resources
    )
