"""Warnings of what a sound spec asks for and nothing can come of, each with the number that says so."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import combinations, product
from operator import attrgetter
from typing import get_args

import numpy as np

from graspdsl.basis.potentials import POTENTIALS, Potential
from graspdsl.basis.resources import ContactSet, JointSet
from graspdsl.basis.spaces import GradientSpace
from graspdsl.compiler.complaints import Complaints
from graspdsl.compiler.general_position import in_general_position
from graspdsl.compiler.graph import (
    Composition,
    ControllerGraph,
    ControllerNode,
    SensorReference,
    VectorReference,
    compositions_in,
    controllers_in,
)
from graspdsl.compiler.phase import CheckedPhase, conditions_lowered
from graspdsl.compiler.pipeline import Pipeline, fingerprint
from graspdsl.compiler.settings import Target, target_of
from graspdsl.diagnostics import Diagnostic, Severity, listed
from graspdsl.hands.descriptions import Robot
from graspdsl.hands.fingertip_motion import FingertipMotion
from graspdsl.objects.shape import SHORTEST
from graspdsl.objects.shapes import Body
from graspdsl.places.document import Document, Path
from graspdsl.spec.models import Spec
from graspdsl.spec.program import Control, Phase, Until
from graspdsl.spec.scene import InlineObject

ROUNDING = 1e-9
OBSERVATIONS = 3  # in general position, that a projection is tried on
VANISHED = 1e-9  # of a displacement, that is left of it by a null space it has no part in


def check_effects(
    spec: Spec,
    robot: Robot,
    motion: FingertipMotion | None,
    phases: Sequence[CheckedPhase | None],
    body: Body | None,
    document: Document,
    complaints: Complaints,
) -> None:
    """Warn of end conditions that always or never hold, and of settings, forces and priorities without effect.

    ``motion``: None where contacts have no hand; ``phases``: one for each of the spec's, None for a faulty one;
    ``body``: None when the object is not known.
    """
    check = _Check(spec, robot, motion, target_of(spec, robot, body), body, document, complaints)
    compiled = list[Pipeline]()
    for index, (settings, phase) in enumerate(zip(spec.program, phases, strict=True)):
        check.times(index, settings, phase)
        if phase is not None:
            pipelines = phase.pipelines(check.target)
            compiled += pipelines
            check.conditions(index, settings.until, phase)
            check.stages(index, settings, phase)
            check.priorities(index, phase, pipelines)
    check.scene()
    check.forces(phases)
    sound = [phase for phase in phases if phase is not None]
    check.damping(sound)
    if len(sound) == len(phases):
        check.control(sound, compiled)


@dataclass(frozen=True)
class _Pressed:
    """A force that a controller asks a contact for: its size [N] and where the number stands."""

    size: float
    contact: int
    label: str
    parameter: str


@dataclass(frozen=True)
class _Check:
    spec: Spec
    robot: Robot
    motion: FingertipMotion | None
    target: Target
    body: Body | None
    document: Document
    complaints: Complaints

    def _warn(self, code: str, message: str, path: Path, hint: str, *, value: bool = False) -> None:
        self.complaints.about(path)
        span = self.document.span(path) if value else self.document.key_span(path)
        self.complaints.warning(code, message, span, hint)

    # --- the scene ----------------------------------------------------------------------------------------------

    def scene(self) -> None:
        """What is said of the mount and of the object and nothing depends on."""
        scene, thing, path = self.spec.scene, self.spec.scene.object, ("scene", "object")
        idle: dict[Path, str] = {}
        lacks = self.target.world.lacks
        if "hand" in lacks and "mount" in scene.model_fields_set:
            idle["scene", "mount"] = lacks["hand"]
        if isinstance(thing, InlineObject) and ("weight" in lacks or thing.fixed):
            why = lacks.get("weight", "the object is fixed to the world")
            idle.update({(*path, "mass"): why} if thing.mass is not None else {})
            idle.update({(*path, "mesh", "density"): why} if thing.mesh and thing.mesh.density is not None else {})
        shape = thing.shape if isinstance(thing, InlineObject) else None
        if shape is not None and "edges" not in lacks:
            given = (key for key in shape.floating_only if key in shape.model_fields_set)
            idle.update(((*path, shape.name, key), "edges are rounded only where contacts float") for key in given)
        for place, why in idle.items():
            self._warn("no-effect", f"{place[-1]} has no effect: {why}", place, "leave it out")

    # --- end conditions -----------------------------------------------------------------------------------------

    def times(self, index: int, settings: Phase, phase: CheckedPhase | None) -> None:
        """A limit of no tick, and conditions that must hold for longer than there is time."""
        path: Path = ("program", index)
        tick, limit, hold = 1.0 / self.target.rate, settings.limit, settings.until.hold
        count = 1 if phase is None else len(phase.stages)
        if limit < tick - ROUNDING:
            message = f"a limit of {limit:g} s is over before the first tick of {tick:g} s"
            self._warn("never-met", message, (*path, "limit"), "limits are in seconds; give the phase some of them")
        elif count * hold > limit + ROUNDING:
            each = f", once for each of {count} stages," if count > 1 else ""
            message = f"the end conditions cannot hold for {hold:g} s{each} within the limit of {limit:g} s"
            given = (*path, "until", "hold") if "hold" in settings.until.model_fields_set else (*path, "limit")
            hint = f"write a hold below {limit / count:g}, or a limit above {count * hold:g}"
            self._warn("never-met", message, given, hint)

    def conditions(self, index: int, until: Until, phase: CheckedPhase) -> None:
        """Bounds that residuals and errors cannot but keep below, or cannot get below."""
        path: Path = ("program", index, "until")
        grasp, bound = phase.grasp, until.force_residual
        total = float(grasp.weights.sum())
        least = max(0.0, 2.0 * float(grasp.weights.max()) - total)
        if bound is not None and bound >= total - ROUNDING:
            message = f"force_residual is always below {bound:g}: of {grasp.label} it is at most {total:g}, the sum of "
            message += "its unit forces"
            self._warn("always-met", message, (*path, "force_residual"), "give a bound well below that, as 0.1")
        elif bound is not None and bound <= least + ROUNDING:
            why, hint = (
                f"of {grasp.label} it is at least {least:g}, for one of its unit forces outweighs all others",
                ("let contacts oppose it: add them to the set"),
            )
            if least <= ROUNDING:
                why, hint = "rounding alone leaves as much", "give a bound that can be felt, as 0.1"
            message = f"force_residual never gets below {bound:g}: {why}"
            self._warn("never-met", message, (*path, "force_residual"), hint)
        self._moment(path, until, grasp)
        strongest = max(self._pressed(phase), key=attrgetter("size"), default=None)
        if until.force_error is not None and strongest is not None and until.force_error >= strongest.size - ROUNDING:
            message = f"force_error is below {until.force_error:g} N for a contact that hardly presses: the largest "
            message += f"force asked for is {strongest.size:g} N"
            self._warn("always-met", message, (*path, "force_error"), "give a bound well below that force")

    def _moment(self, path: Path, until: Until, grasp: ContactSet) -> None:
        """‖Σ w (p − c) × n‖ ≤ Σ w ‖p − c‖, for points no farther apart than the object's diagonal d: about their
        centroid ‖p_i − c‖ ≤ d (W − w_i) / W with W = Σ w; about the centre of mass ‖p_i − c‖ ≤ d."""
        bound, origin = until.moment_residual, self.spec.control.origin
        if bound is None or self.body is None or origin == "world":
            return
        total, squared = float(grasp.weights.sum()), float(grasp.weights @ grasp.weights)
        diagonal = float(np.linalg.norm(self.body.shape.extent))
        most = diagonal * (total if origin == "object" else total - squared / total)
        if bound >= most - ROUNDING and diagonal >= SHORTEST:  # a smaller object has had its complaint
            message = f"moment_residual is always below {bound:g} m: of {grasp.label} on an object {diagonal:.3g} m "
            message += f"across it is at most {most:.3g} m"
            hint = "give a bound well below that, as 0.005" if most > ROUNDING else "leave it out: one contact has none"
            self._warn("always-met", message, (*path, "moment_residual"), hint)

    def stages(self, index: int, settings: Phase, phase: CheckedPhase) -> None:
        """Hysteresis where no earlier stage has a residual to give up."""
        waited = {name for name in ("force_residual", "moment_residual") if getattr(settings.until, name) is not None}
        lowered = {name for stage in phase.stages[:-1] for name in conditions_lowered(stage)}
        if settings.hysteresis is not None and not waited & lowered:
            why = "no earlier stage has a residual to hold" if len(phase.stages) > 1 else "there is no 'a then b' here"
            message = f"hysteresis has no effect: {why}"
            self._warn("no-effect", message, ("program", index, "hysteresis"), "leave it out")

    # --- priorities ---------------------------------------------------------------------------------------------

    def priorities(self, index: int, phase: CheckedPhase, pipelines: Sequence[Pipeline]) -> None:
        """Lower levels of which the higher ones leave nothing, and force below what moves the same contacts."""
        path: Path = ("program", index, "run")
        gone = dict(self._nothing_left(pipelines))
        yielding = dict(pair for graph in phase.executed(self.target) for pair in _yielding_forces(graph, self.robot))
        for force, other in yielding.items():
            left = "nothing is left of it" if force in gone else "where the two disagree, it is the force that yields"
            message = f"{force}, which presses, gives way to {other} of the same fingers: {left}"
            hint = f"the right of ◁ goes first: write {other}… ◁ {force}…, as Eq. 4.22 and 4.26 have it"
            self._warn("force-gives-way", message, path, hint, value=True)
        for lower, higher in gone.items():
            if lower not in yielding:
                leaving = "leaves" if len(higher) == 1 else "leave"
                message = f"nothing is left of {lower}: {listed(higher)} before it {leaving} it no motion"
                hint = "the right of ◁ goes first; let what is lower move something that the higher do not"
                self._warn("no-effect", message, path, hint, value=True)

    def _nothing_left(self, pipelines: Sequence[Pipeline]) -> Iterator[tuple[str, tuple[str, ...]]]:
        """Levels that the null space of the higher ones takes away whatever is observed."""
        for pipeline in pipelines:
            seen = [pipeline.values(in_general_position(self.robot, seed)) for seed in range(OBSERVATIONS)]
            for found in pipeline.projections:
                sizes = [[np.linalg.norm(values[step]) for step in (found.before, found.after)] for values in seen]
                if all(after <= VANISHED * before and before > 0.0 for before, after in sizes):
                    yield found.lower, found.higher

    # --- forces and gains ---------------------------------------------------------------------------------------

    def _pressed(self, phase: CheckedPhase) -> Iterator[_Pressed]:
        """The forces that references ask contacts for, as far as they are numbers."""
        for node in self._nodes([phase]):
            resources, reference = node.sensor_resources, node.reference
            if not _asks_forces(node) or not isinstance(resources, ContactSet):
                continue
            if isinstance(reference, SensorReference) and reference.sensor.makes_forces:
                sizes, parameter = [reference.factor] * len(resources.members), reference.parameter
            elif isinstance(reference, VectorReference):
                sizes = np.linalg.norm(np.array(reference.values).reshape(-1, 3), axis=1).tolist()
                parameter = reference.label
            else:
                continue
            shared = self.spec.control.virtual_forces == "shared"
            for member, size in zip(resources.members, sizes, strict=True):
                for contact, weight in member.weights:
                    if contact in resources.contacts:
                        pressed = size * weight if shared else size
                        yield _Pressed(pressed, contact, parameter or reference.label, parameter)

    def forces(self, phases: Sequence[CheckedPhase | None]) -> None:
        """Forces beyond what the fingers can press with, and those under which a touch ends."""
        if self.motion is None:
            return
        presses = self.motion.strongest()
        asked = [(index, force) for index, phase in enumerate(phases) if phase for force in self._pressed(phase)]
        ends, told = self.target.world.sensor(self.spec.scene.sensing).touch.ends, set[str]()
        for index, force in asked:
            name, press = self.robot.contacts[force.contact], presses[force.contact]
            asks = f"{force.label} asks {name} for {force.size:g} N"
            if force.label in told:
                continue
            if press is not None and force.size > press.force:
                message = f"{asks}, more than the {press.force:.3g} N that it can press with as it closes, where "
                message += f"{press.joint} has {press.strength}"
                code, hint = "beyond-strength", f"ask for less than {press.force:.2g} N"
            elif force.size <= ends:
                message = f"{asks}, where a touch ends at {ends:g} N: a contact that presses so does not touch"
                code, hint = "too-weak", f"ask for more than {ends:g} N, or let touches end below: touch: {{ends: …}}"
            else:
                continue
            told.add(force.label)
            self.complaints.about(("program", index, "run"))
            complaint = Diagnostic(code, message, self.document.span(("program", index, "run")), hint, Severity.WARNING)
            self.complaints.of_parameter(force.parameter, complaint)

    def damping(self, phases: Sequence[CheckedPhase]) -> None:
        """A pseudo-inverse does σ²/(σ² + λ²) of a step along a singular direction; less than half where λ > σ."""
        control = self.spec.control
        if self.motion is None or control.inverse != "pseudo-inverse":
            return
        for potential in self._potentials(phases):
            if potential.law.damped:
                largest = self.motion.largest_singular_value(potential.difference.turns, control.damping)
                if largest < control.damping:
                    share = largest**2 / (largest**2 + control.damping**2)
                    message = f"a damping of {control.damping:g} leaves at most {100 * share:.2g} % of each step: the "
                    message += f"largest singular value of the contacts' Jacobian is {largest:.2g}"
                    hint = f"give a damping well below {largest:.2g}; 0.02 is usual"
                    self._warn("over-damped", message, ("control", "damping"), hint)
                    return

    def control(self, phases: Sequence[CheckedPhase], pipelines: Sequence[Pipeline]) -> None:
        """Gains of zero, and settings that no pipeline of the program depends on: those of all phases, as they are."""
        control = self.spec.control
        for potential in self._potentials(phases):
            gain = potential.law.gain
            if gain and getattr(control, gain) == 0.0:
                message = f"with {gain} 0, {potential.symbol} {potential.law.without}"
                self._warn("no-effect", message, ("control", gain), "leave it out")
        waits = any(p.until.force_residual or p.until.moment_residual for p in self.spec.program)
        as_set = _numbers(pipelines)
        for name in sorted(control.model_fields_set - {"backend"}):  # which changes no pipeline, but what runs it
            watched = name == "curvature_radius" and waits  # it weighs the residuals that must fall
            if getattr(control, name) is not None and not watched and not self._matters(name, phases, as_set):
                message = f"{name} has no effect: no controller of the program depends on it"
                self._warn("no-effect", message, ("control", name), "leave it out")

    def _matters(self, name: str, phases: Sequence[CheckedPhase], as_set: object) -> bool:
        """Whether another value of a setting makes another pipeline."""
        field, value = Control.model_fields[name], getattr(self.spec.control, name)
        others = get_args(field.annotation) if isinstance(value, str) else (2.0 * value if value else 1.0,)
        changed = (self.spec.control.model_copy(update={name: other}) for other in others if other != value)
        targets = (replace(self.target, control=control) for control in changed)
        compiled = ([pipeline for phase in phases for pipeline in phase.pipelines(target)] for target in targets)
        return any(_numbers(pipelines) != as_set for pipelines in compiled)

    def _potentials(self, phases: Sequence[CheckedPhase]) -> list[Potential]:
        """The potentials of all controllers, each once, in the order of their table."""
        used = {node.potential.symbol for node in self._nodes(phases)}
        return [potential for symbol, potential in POTENTIALS.items() if symbol in used]

    def _nodes(self, phases: Sequence[CheckedPhase]) -> Iterator[ControllerNode]:
        for phase in phases:
            for graph in phase.executed(self.target):
                yield from controllers_in(graph)


def _numbers(pipelines: Sequence[Pipeline]) -> object:
    """All that pipelines compute, to be compared."""
    return [[(fingerprint(step.function), step.inputs, step.reading) for step in made.steps] for made in pipelines]


def _yielding_forces(graph: ControllerGraph, robot: Robot) -> Iterator[tuple[str, str]]:
    """The potentials of each force controller and of what goes before it and moves the same contacts."""
    for chain in compositions_in(graph):
        for lower, higher in combinations(chain.terms, 2):
            for force, other in product(_levels(lower), _levels(higher)):
                if _asks_forces(force) and _moves_the_same(force, other, robot):
                    yield force.potential.symbol, other.potential.symbol


def _asks_forces(node: ControllerNode) -> bool:
    """Whether a controller's reference is what contacts press with."""
    return "force_error" in node.potential.lowers


def _levels(graph: ControllerGraph) -> list[ControllerNode]:
    """The single controllers of a chain."""
    return [node for term in graph.terms for node in _levels(term)] if isinstance(graph, Composition) else [graph]


def _moves_the_same(force: ControllerNode, other: ControllerNode, robot: Robot) -> bool:
    """Whether another controller places a contact of a force controller, or all the joints of its finger."""
    pressed, placed = force.sensor_resources, other.sensor_resources
    assert isinstance(pressed, ContactSet)
    if other.potential.displaced_by is GradientSpace.CARTESIAN and isinstance(placed, ContactSet):
        return not set(pressed.contacts).isdisjoint(placed.contacts)
    if isinstance(placed, JointSet) and isinstance(other.effector_resources, JointSet):
        joints = list(robot.joints)
        kept = {joints[joint] for joint in set(placed.joints) & set(other.effector_resources.joints)}
        fingers = [set(contact.finger) for contact in robot.hand.contacts.values()]
        return any(fingers[contact] <= kept for contact in pressed.contacts)
    return False
