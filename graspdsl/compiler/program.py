"""A whole spec, checked: every formula resolved, every fault of the file found at once."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from itertools import islice
from pathlib import Path as FilePath
from typing import NamedTuple, TypeVar

from graspdsl.basis.potentials import lowering
from graspdsl.basis.prelude import Definition, prelude
from graspdsl.basis.spaces import GradientSpace
from graspdsl.compiler.backend_check import unfit
from graspdsl.compiler.check import Checker
from graspdsl.compiler.complaints import Complaints, span_of
from graspdsl.compiler.declarations import DEFAULT_WORLD, HAND, MOUNT, Declarations, PhaseEntry, declarations_of
from graspdsl.compiler.definitions import definitions_with, used_in
from graspdsl.compiler.effects_check import check_effects
from graspdsl.compiler.graph import controllers_in
from graspdsl.compiler.monitors_check import check_monitors
from graspdsl.compiler.object_check import file_hint, found_object
from graspdsl.compiler.phase import CheckedPhase, conditions_lowered, executable, grasp_of
from graspdsl.compiler.pipeline import Pipeline
from graspdsl.compiler.resources import ResourceTable
from graspdsl.compiler.scene_check import check_mount, check_scene, check_sensing, hand_for_floating
from graspdsl.compiler.settings import Target, different_trials, target_of
from graspdsl.compiler.start_check import check_sizes, check_start_posture, check_trials
from graspdsl.compiler.surroundings import OBJECT, USUAL, Surroundings
from graspdsl.compiler.sweep_check import check_sweep, complaints_at
from graspdsl.diagnostics import (
    Diagnostic,
    DiagnosticError,
    Fix,
    SourceText,
    has_errors,
    in_reading_order,
    known_names_hint,
    likely,
)
from graspdsl.hands.descriptions import Hand, Mount, Robot, hands, mounts, robot
from graspdsl.hands.fingertip_motion import FingertipMotion
from graspdsl.hands.mount_check import taken_names
from graspdsl.notation.names import canonical
from graspdsl.notation.parser import parse_definition, parse_expression
from graspdsl.notation.tree import Expression
from graspdsl.objects.shapes import Body, catalogue
from graspdsl.places.document import Document, Path
from graspdsl.places.files import NamedFile, SpecFolder
from graspdsl.places.folders import names_a_file, told_of
from graspdsl.plugins.adoption import Adoption, adopted, adopted_in
from graspdsl.plugins.answering import answered_for
from graspdsl.plugins.kinds import Plugin, is_built_in, with_offered
from graspdsl.spec.loading import Known, Reading, Written, load_spec_text, read_document, spec_of
from graspdsl.spec.models import Spec
from graspdsl.spec.monitors import MonitorBounds
from graspdsl.spec.overrides import makes_sweep
from graspdsl.spec.sweeping import setting, settings
from graspdsl.worlds.kind import WorldKind
from graspdsl.worlds.kinds import WORLDS, absence, worlds_with

T = TypeVar("T")
Read = tuple[T, tuple[Diagnostic, ...]]  # of a file, and warnings
HERE = FilePath()
AROUND = "formula.yaml"  # the spec that is written around a formula
OCTAL = re.compile(r"([-+]?)0{1,50}([0-7]{1,50})")


class Source(NamedTuple):
    """What a program is read from: the text of a spec, the name of its file, overrides as ``--set`` takes them, the
    folder of the files that it names by relative paths, and whether Python files among these may be run."""

    text: str
    name: str
    overrides: tuple[str, ...] = ()
    folder: FilePath = HERE
    allow_code: bool = False


@dataclass(frozen=True, slots=True, repr=False)
class Program:
    """A spec that is sound, with its robot, its world, its checked phases, its object and the files that make it.

    ``definitions``: the controllers there are by name, the prelude's and its own. ``plugins``: what it uses of other
    packages and of its own code. ``points``: the overrides that make of its spec that of each point of its sweep, which
    is none.
    """

    source: Source
    spec: Spec
    robot: Robot
    world: WorldKind
    phases: tuple[CheckedPhase, ...]
    body: Body
    files: tuple[NamedFile, ...] = ()
    definitions: Mapping[str, Definition] = field(default_factory=prelude)
    plugins: tuple[Plugin, ...] = ()
    points: tuple[tuple[str, ...], ...] = ()
    _at: dict[int, Program] = field(default_factory=dict, init=False, compare=False)  # points that were asked for

    def __repr__(self) -> str:
        phases = "; ".join(phase.label for phase in self.phases)
        return f"<Program {self.spec.name}, {self.spec.scene.world}: {phases}>"

    @property
    def probes(self) -> bool:
        """Whether a displacement of the contacts is one probe, and not one tick."""
        return self.target.probes

    @property
    def target(self) -> Target:
        """What the program's pipelines drive."""
        return target_of(self.spec, self.robot, self.body)

    @property
    def different_trials(self) -> float:
        """How many of its trials can differ from one another, inf for any number; all others repeat them."""
        return different_trials(self.spec)

    def at(self, point: int) -> Program:
        """The program of a point of its sweep: the same with other values. Raises DiagnosticError where that cannot
        be."""
        if point not in self._at:
            self._at[point] = program_of(*self.source._replace(overrides=self.points[point]))
        return self._at[point]

    def of_trial(self, number: int) -> tuple[Program, int]:
        """What a trial is of: the program of its point, and its number there; of no sweep, the program itself."""
        if not self.points:
            return self, number
        point, own = divmod(number, self.spec.trials.count)
        return self.at(point), own

    @property
    def trials(self) -> int:
        """How many trials there are, at all points."""
        return self.spec.trials.count * max(1, len(self.points))

    @property
    def monitors(self) -> MonitorBounds:
        """The monitors as they act on the scene."""
        return self.spec.monitors.in_effect(held=self.spec.scene.held)

    def pipelines(self) -> tuple[tuple[Pipeline, ...], ...]:
        """The compiled stages of every phase."""
        return tuple(phase.pipelines(self.target) for phase in self.phases)


@dataclass(frozen=True, slots=True)
class Examination:
    """What became of a spec: its program when it has no errors, and every complaint."""

    program: Program | None
    diagnostics: tuple[Diagnostic, ...]


def known_names(document: Document | None = None) -> Known:
    """The worlds, mounts and grades that specs may name, with a line on each; grades not for one that names none."""
    known = {
        "worlds": {name: world.about for name, world in WORLDS.items()},
        "mounts": {name: mount.about for name, mount in mounts().items()},
    }
    if document is None or document.has(("evaluate",)):
        from graspdsl.quality.grades import GRADES

        known["grades"] = {name: grade.about for name, grade in GRADES.items()}
    return known


def examine(
    text: str,
    name: str,
    overrides: tuple[str, ...] = (),
    folder: FilePath = HERE,
    allow_code: bool = False,
    points: int | None = None,
) -> Examination:
    """Check the text of a spec, faults of YAML, of values and of formulas all in one go, at every point of its sweep,
    or at the first ``points``.

    Files that the spec names by relative paths are in ``folder``; its Python files are run where code is allowed.
    """
    source = Source(text, name, overrides, folder, allow_code)
    examination = _examined(source)
    program = examination.program
    if program is None or not program.points:
        return examination
    found = []
    assert program.spec.sweep is not None
    pairs = zip(program.spec.sweep.points(), program.points, strict=True)
    for number, (point, overridden) in enumerate(islice(pairs, points)):
        at = _examined(source._replace(overrides=overridden))
        if at.program is not None:
            program._at[number] = at.program
        missing = missing_engine(at.program) if at.program else None
        found.append((number, point, (*at.diagnostics, *([missing] if missing else []))))
    document = read_document(text, name, overrides).document
    others = complaints_at(program.spec.sweep, document, found, examination.diagnostics)
    diagnostics = in_reading_order([*examination.diagnostics, *others])
    return Examination(None if has_errors(diagnostics) else program, diagnostics)


def _examined(source: Source) -> Examination:
    """What becomes of a spec, whatever it is at the points of its sweep."""
    try:
        written = read_document(source.text, source.name, source.overrides)
    except DiagnosticError as error:
        return Examination(None, in_reading_order(error.diagnostics))
    adoption = adopted(written.document, source.folder, allow_code=source.allow_code)
    try:
        with answered_for(adoption.plugins):
            return _judged(written, adoption, source)
    except DiagnosticError as error:
        return Examination(None, in_reading_order([*adoption.faults, *error.diagnostics]))


def _judged(written: Written, adoption: Adoption, source: Source) -> Examination:
    folder = source.folder
    reading = spec_of(written, known_names(written.document))
    spec, document = reading.spec, reading.document
    complaints = Complaints(document, spec.parameters)
    hand_files = SpecFolder(folder)
    check = _ProgramCheck(declarations_of(spec, document), complaints, hand_files, adoption.controllers)
    phases = check.phases()
    _parameters_once(spec, document, complaints)
    check_scene(spec, document, complaints)
    _leading_zeros(document, complaints)
    placed = reading.is_sound("scene")
    if placed and reading.is_sound("control", "program", "monitors"):
        check_monitors(spec, document, complaints)
    if placed and reading.is_sound("trials"):
        check_trials(spec, document, complaints)
        check_sweep(spec, document, complaints)
    thing = found_object(spec, document, complaints, folder) if placed else None
    if thing is not None:
        spec = spec.before(thing[0].shape.extent[2])
    if check.robot is not None and reading.is_sound("trials"):
        check_start_posture(spec, check.robot, document, complaints)
    if check.robot is not None and placed:
        check_sensing(spec, document, check.robot, complaints)
        check_mount(spec, document, check.robot, complaints)
    if check.robot is not None and placed and not reading.unread:
        moves = WORLDS[spec.scene.world].has("hand") and check.robot.has_model
        motion = FingertipMotion(check.robot) if moves else None
        check_effects(spec, check.robot, motion, phases, thing and thing[0], document, complaints)
        if thing is not None and motion is not None:
            check_sizes(spec, check.robot.hand, motion, thing[0], document, complaints)
    found = [*reading.faults, *_own(complaints.found, reading)]
    found = [complaint for complaint in found if not adoption.explains(complaint)]
    diagnostics = in_reading_order([*adoption.faults, *found])
    if check.robot is None or thing is None or has_errors(diagnostics):
        return Examination(None, diagnostics)
    body, object_files = thing
    files = (*hand_files.files, *object_files, *adoption.files)
    world, definitions = WORLDS[spec.scene.world], check.definitions
    sound = tuple(phase for phase in phases if phase is not None)
    points = _points(spec, document, source.overrides)
    program = Program(source, spec, check.robot, world, sound, body, files, definitions, adoption.plugins, points)
    return Examination(program, diagnostics)


def _points(spec: Spec, document: Document, overrides: tuple[str, ...]) -> tuple[tuple[str, ...], ...]:
    """The overrides of each point of a sweep: those there are but for what makes it a sweep, and its values."""
    if spec.sweep is None:
        return ()
    kept = tuple(override for override in overrides if not makes_sweep(override))
    unmade = (setting("sweep", None),) if ("sweep",) in document.places else ()
    return tuple((*kept, *unmade, *settings(point)) for point in spec.sweep.points())


def _parameters_once(spec: Spec, document: Document, complaints: Complaints) -> None:
    seen = set[str]()
    for key in spec.parameters:
        path: Path = ("parameters", key)
        name = canonical(key)
        if name in seen:
            complaints.about(path)
            message = f"{name} is declared twice, in two spellings"
            complaints.error("declared-twice", message, document.key_span(path), "keep one of them")
        seen.add(name)


def _leading_zeros(document: Document, complaints: Complaints) -> None:
    """Warn of whole numbers with a leading zero, which YAML 1.1 has for octal ones."""
    for path, text in _whole_numbers(document):
        found = OCTAL.fullmatch(text)
        decimal, octal = (int(found[1] + found[2], base) for base in (10, 8)) if found else (0, 0)
        if decimal != octal:
            complaints.about(path)
            message = f"{text} is read as {decimal}; YAML 1.1 has it for the octal number {octal}"
            span = document.span(path)
            fixes = [Fix(span, f"{decimal}")] if span else []
            complaints.warning("leading-zero", message, span, f"write {decimal}", fixes)


def _whole_numbers(document: Document) -> Iterator[tuple[Path, str]]:
    """Whole numbers as they are written, in the file or on the command line."""
    for path, words in document.overrides.items():
        if type(document.get(path)) is int:
            yield path, words.partition("=")[2].strip()
    for path, place in document.places.items():
        if document.origin(path) is None and type(document.get(path)) is int:
            yield path, place.value.value or ""


# What is complained of when the section that declares it cannot be read, which has had its complaint.
_DECLARED_IN = {"unknown-resource": "resources", "unknown-controller": "controllers", "missing-parameter": "parameters"}


def _own(found: Iterable[Diagnostic], reading: Reading) -> list[Diagnostic]:
    """The complaints that do not follow from a section that is missing or no mapping."""
    return [said for said in found if (_DECLARED_IN.get(said.code),) not in reading.unread]


def program_of(
    text: str, name: str, overrides: tuple[str, ...] = (), folder: FilePath = HERE, allow_code: bool = False
) -> Program:
    """The program of a spec without errors, whatever it is at the points of its sweep; otherwise raises
    DiagnosticError."""
    examination = _examined(Source(text, name, overrides, folder, allow_code))
    if examination.program is None:
        raise DiagnosticError(examination.diagnostics)
    return examination.program


def missing_engine(program: Program) -> Diagnostic | None:
    """What there is to say of a sound spec that this Python cannot run, at its place; else None."""
    source, missing = program.source, lacking(program)
    if missing is None:
        return None
    complaint, path = missing
    document = read_document(source.text, source.name, source.overrides).document
    return document.attributed(path, replace(complaint, span=document.span(path)))


def lacking(program: Program) -> tuple[Diagnostic, Path] | None:
    """What keeps this Python from running a program, and which key of the spec asks for it: a world or a backend that
    needs what is not installed, or a backend that cannot evaluate what a plug-in brings."""
    if (missing := absence(program.world)) is not None:
        return missing, ("scene", "world")
    foreign = program.pipelines() if program.plugins else ()
    refused = unfit(program.target.backend, foreign, program.robot)
    return None if refused is None else (refused, ("control", "backend"))


def examine_expression(text: str, around: Surroundings = USUAL) -> tuple[CheckedPhase, Robot]:
    """Check a formula outside a spec; of a definition, what it stands for.

    Raises DiagnosticError about it, or about the spec written of what is around.
    """
    complaints, adoption = Complaints(), adopted_in(text)
    check = _check_around(_named(around), complaints, adoption)
    phase = check.phase(SourceText.of(text), (), lambda source: parse_definition(source)[1])
    if phase is None or check.robot is None or has_errors(adoption.faults):
        found = [complaint for complaint in complaints.found if not adoption.explains(complaint)]
        raise DiagnosticError(in_reading_order([*adoption.faults, *found]))
    return phase, check.robot


def _named(around: Surroundings) -> Surroundings:
    """What is around a formula, with names for the contacts of the hand where none are given."""
    if around.resources is not None:
        return around
    robot = _check_around(around, Complaints(), Adoption()).robot
    return around.of_all(robot.contacts if robot else ())


def _check_around(around: Surroundings, complaints: Complaints, adoption: Adoption) -> _ProgramCheck:
    """What checks a formula of which there is an adoption, as of the spec that is written around it."""
    written = around.written("π_close|Γ Γ", held=bool(around.held), displacement="sliding")
    of_spec = read_document(written, AROUND)
    named = adopted(of_spec.document, HERE)
    found = spec_of(of_spec, known_names(of_spec.document))
    declarations = replace(declarations_of(found.spec, found.document), senses_gravity=True)
    controllers = {**named.controllers, **adoption.controllers}
    check = _ProgramCheck(declarations, complaints, SpecFolder(HERE), controllers)
    faults = [complaint for complaint in (*found.faults, *complaints.found) if not named.explains(complaint)]
    if has_errors([*named.faults, *faults]):
        raise DiagnosticError(in_reading_order([*named.faults, *faults]), AROUND, written)
    complaints.found.clear()
    return check


def program_of_expression(text: str, around: Surroundings = USUAL) -> Program:
    """The program whose one phase is a formula outside a spec. Raises DiagnosticError as :func:`examine_expression`.

    Where nothing is said of them, the object is held where the formula turns contacts or senses gravity, and contacts
    are displaced by probing where it commands their displacements.
    """
    around = _named(around)
    phase, whole = examine_expression(text, around)
    kind = WORLDS[DEFAULT_WORLD]
    slides = {stage.gradient_space for stage in phase.stages} <= kind.sliding | {GradientSpace.ROTATION}
    written = around.written(
        phase.label,
        held=phase.holds if around.held is None else around.held,
        displacement="sliding" if slides else "probing",
    )
    spec = load_spec_text(written, AROUND).spec
    return Program(Source(written, AROUND), spec, whole, kind, (phase,), catalogue()[OBJECT])


def _hand_of_file(files: SpecFolder, name: str) -> Read[Hand]:
    from graspdsl.hands.hand_files import hand_in

    found = hand_in(files, name)
    return found.hand, found.warnings


def _mount_of_file(files: SpecFolder, name: str) -> Read[Mount]:
    from graspdsl.hands.mount_files import mount_in

    found = mount_in(files, name)
    return found.mount, found.warnings


class _ProgramCheck:
    def __init__(
        self,
        declarations: Declarations,
        complaints: Complaints,
        files: SpecFolder,
        controllers: Mapping[str, Definition],
    ) -> None:
        self._declarations, self._complaints, self._files = declarations, complaints, files
        self._world = WORLDS.get(declarations.world or "")
        self.robot = self._robot()
        self._named(declarations.object_path, declarations.object, catalogue(), "object")
        definitions = definitions_with(declarations.controllers, complaints, controllers)
        table = ResourceTable(
            declarations.resources,
            self.robot,
            complaints,
            senses_gravity=declarations.senses_gravity,
            weightless=declarations.weightless,
            unread=declarations.unread,
            other_hand=hand_for_floating(declarations),
        )
        self._checker = Checker(table, definitions, declarations.parameters, complaints)
        self._checker.check_definitions()

    @property
    def definitions(self) -> Mapping[str, Definition]:
        """The controllers that formulas may name."""
        return self._checker.definitions

    def _robot(self) -> Robot | None:
        """The hand on its mount, if both are known and no name of the one is a name of the other."""
        scene = self._declarations
        hand = self._described(HAND, scene.hand, hands(), _hand_of_file)
        mount = self._described(MOUNT, scene.mount, mounts(), _mount_of_file)
        if scene.hand is None or scene.mount is None or hand is None or mount is None:
            return None
        named = (("hands", scene.hand.text), ("mounts", scene.mount.text))
        if not any(names_a_file(name) for _, name in named) and all(map(is_built_in, named)):
            return robot(scene.hand.text, scene.mount.text)
        whole = Robot(hand=hand, mount=mount)
        taken = tuple(taken_names(whole))
        self._tell(HAND, scene.hand, taken)
        return None if taken else whole

    def _described(
        self, path: Path, name: SourceText | None, known: Mapping[str, T], read: Callable[[SpecFolder, str], Read[T]]
    ) -> T | None:
        """A hand or a mount of the catalogue, or of a file; the faults of a file are reported where the spec names it,
        each with its place in the file."""
        if name is None:
            return None
        if not names_a_file(name.text):
            return known[name.text] if self._named(path, name, known, str(path[-1])) else None
        from graspdsl.hands.description_files import DescriptionFileError

        self._complaints.about(path)
        found: T | None = None
        faults: tuple[Diagnostic, ...] = ()
        try:
            found, faults = read(self._files, name.text)
        except DiagnosticError as error:
            for fault in error.diagnostics:
                self._complaints.error(fault.code, fault.message, span_of(name), fault.hint)
        except DescriptionFileError as error:
            faults = error.diagnostics
        self._tell(path, name, faults)
        return found

    def _tell(self, path: Path, name: SourceText, faults: Iterable[Diagnostic]) -> None:
        """Report faults of a file where the spec names it, each with its place in the file."""
        self._complaints.about(path)
        for fault in told_of(name.text, faults):
            self._complaints.add(replace(fault, span=span_of(name)))

    def _named(self, path: Path, name: SourceText | None, known: Mapping[str, object], what: str) -> bool:
        if name is None or name.text in known:
            return True
        self._complaints.about(path)
        document = self._declarations.document
        given = document is not None and document.origin(path) is not None
        of_file = file_hint(name.text, given) if what == "object" else None
        there = with_offered(f"{what}s", known)
        self._complaints.error(
            f"unknown-{what}",
            f"there is no {what} {name.text!r}",
            span_of(name),
            of_file or known_names_hint(name.text, there, f"{what}s"),
            () if of_file else likely(name.text, there, span_of(name)),
        )
        return False

    def phases(self) -> tuple[CheckedPhase | None, ...]:
        """The phases of which there is a formula; None, and complaints, in place of one that is not sound."""
        phases = []
        for entry in self._declarations.phases:
            phase = self.phase(entry.formula, entry.path)
            if phase is not None:
                self._fits_world(phase, entry)
                self._has_residuals(phase, entry)
            phases.append(phase)
        return tuple(phases)

    def phase(
        self, formula: SourceText, path: Path, read: Callable[[SourceText], Expression] = parse_expression
    ) -> CheckedPhase | None:
        """One formula, parsed and checked."""
        self._complaints.about(path)
        try:
            tree = read(formula)
        except DiagnosticError as error:
            self._complaints.take(error)
            return None
        stages = self._checker.stages(tree)
        return (
            None
            if stages is None or self.robot is None
            else CheckedPhase(tree, stages, grasp_of(stages, self.robot), used_in(tree, self._checker.definitions))
        )

    def _fits_world(self, phase: CheckedPhase, entry: PhaseEntry) -> None:
        world = self._world
        if world is None:
            return
        way = self._declarations.displacement
        by_joints = GradientSpace.JOINTS in world.spaces(way)
        able = world.spaces(way) | ({GradientSpace.ROTATION} if self._declarations.holds else set())
        for stage in phase.stages:
            space = stage.gradient_space
            nodes = controllers_in(stage)
            curved = sorted({node.effector.symbol for node in nodes if "shape_operators" in node.effector.reads})
            lacking = sorted({node.sensor.symbol for node in controllers_in(stage) if "forces" in node.sensor.reads})
            if lacking and not world.has("forces"):
                self._complaints.error(
                    "not-sensed",
                    f"{world.lacks['forces']}: {', '.join(lacking)} cannot be sensed in the {world.name} world",
                    span_of(entry.formula),
                    f"use σ_fr and σ_mr, as π_gx does, or {worlds_with('forces')}",
                )
            elif curved and not world.knows_surface:
                self._complaints.error(
                    "not-sensed",
                    f"no contact senses how a surface curves: the {world.name} world has no {', '.join(curved)}",
                    span_of(entry.formula),
                    "use τ_wx, which takes the surface for a sphere and a plane, or the floating world",
                )
            elif space not in able:
                can = ", ".join(sorted(f"{s.value}, {s.about}" for s in able))
                self._complaints.error(
                    "world-cannot-execute",
                    f"the {world.name} world cannot carry out a gradient in {space.value}, {space.about}, by {way}",
                    span_of(entry.formula),
                    f"it carries out {can}"
                    + ("; make the controller the reference of one, as π_s|Γ Γ (…) does" if by_joints else ""),
                )

    def _has_residuals(self, phase: CheckedPhase, entry: PhaseEntry) -> None:
        world = self._world
        probes = world is not None and world.probes(self._declarations.displacement)
        executed = [executable(stage, probes) for stage in phase.stages]
        lowered = {name for stage in executed for name in conditions_lowered(stage)}
        for key, potentials in lowering().items():
            if key in entry.conditions and key not in lowered and self._declarations.document:
                path: Path = (*entry.path[:-1], "until", key)
                self._complaints.about(path)
                self._complaints.warning(
                    "residual-not-controlled",
                    f"{key} is waited for, but no controller of this phase lowers it",
                    self._declarations.document.key_span(path),
                    f"wait for something else, or run a controller with {potentials[0].symbol}",
                )
