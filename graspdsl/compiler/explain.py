"""What a formula means: what it stands for, its spaces and shapes, and the pipeline it becomes."""

from __future__ import annotations

from dataclasses import astuple, dataclass
from typing import Any

import numpy as np

from graspdsl.backends import NUMPY
from graspdsl.basis.entry import cited
from graspdsl.basis.prelude import Definition
from graspdsl.basis.resources import ContactSet, JointSet
from graspdsl.basis.sensors import measuring
from graspdsl.compiler.general_position import in_general_position
from graspdsl.compiler.graph import (
    Composition,
    ControllerGraph,
    ControllerNode,
    ControllerReference,
    SensorReference,
    VectorReference,
    controllers_in,
)
from graspdsl.compiler.known import facts_about, protection, reference_of, summed_plainly, written
from graspdsl.compiler.phase import CheckedPhase
from graspdsl.compiler.pipeline import Pipeline, Step
from graspdsl.compiler.profiling import Profile, profiled
from graspdsl.compiler.program import Program
from graspdsl.compiler.settings import Target
from graspdsl.notation.printer import to_ascii, to_latex, to_unicode


@dataclass(frozen=True, slots=True)
class Explanation:
    """A checked formula with everything there is to say of it.

    A stage of ``then`` has one of ``executed``, its controller as it is carried out, and the pipeline that runs.
    """

    phase: CheckedPhase
    target: Target
    executed: tuple[ControllerGraph, ...]
    pipelines: tuple[Pipeline, ...]
    shapes: tuple[tuple[tuple[int, ...], ...], ...]

    def unicode(self) -> str:
        """The formula in Unicode."""
        return to_unicode(self.phase.formula)

    def ascii(self) -> str:
        """The formula in ASCII."""
        return to_ascii(self.phase.formula)

    def latex(self) -> str:
        """The formula in LaTeX's mathematics."""
        return to_latex(self.phase.formula)

    def tree(self) -> str:
        """The controllers by priority, with their equations, spaces and shapes."""
        blocks = [self._stage(graph, f"stage {i + 1}") for i, graph in enumerate(self.executed)]
        return "\n".join(blocks)

    def pipeline(self, *, profile: bool = False) -> str:
        """The numerical steps, as trees from the command and from what is monitored down to what is read; a step shown
        before is only named. With a profile: how long each takes, for contacts and joints at random."""
        observation = in_general_position(self.target.robot)
        profiles = [profiled(made, observation) if profile else None for made in self.pipelines]
        each = zip(self.pipelines, self.shapes, self._plain(), profiles, strict=True)
        return "\n".join(_pipeline_tree(*one) for one in each)

    def text(self) -> str:
        """All of it, for a terminal."""
        rows = [f"formula    {self.unicode()}", f"ASCII      {self.ascii()}"]
        rows += [f"stands for {written(graph)}" for graph in self.phase.stages]
        if self.executed != self.phase.stages:
            rows += [f"runs as    {written(graph)}" for graph in self.executed]
        rows += [f"runs       {self._pace()}"]
        rows += ["", "definitions", *map(_definition, self.phase.uses)] if self.phase.uses else []
        rows += ["", "resources", *self._resources(), "", "controllers, highest priority first", self.tree(), ""]
        rows += [f"priority: {said}" for said in self.protected()]
        rows += [f"note: {note}" for note in self.notes()]
        rows += ["", "pipeline", self.pipeline()]
        return "\n".join(rows)

    def as_dict(self) -> dict[str, Any]:
        """All of it, as plain data."""
        return {
            "unicode": self.unicode(),
            "ascii": self.ascii(),
            "latex": self.latex(),
            "stands_for": [written(graph) for graph in self.phase.stages],
            "runs_as": [written(graph) for graph in self.executed],
            "rate": self.target.rate,
            "displacement": self.target.control.displacement,
            "backend": self.target.backend.name,
            "definitions": [
                {
                    "head": to_unicode(definition.head),
                    "body": to_unicode(definition.body) if definition.body else "",
                    "equation": definition.equation,
                    "about": definition.about,
                }
                for definition in self.phase.uses
            ],
            "priorities": self.protected(),
            "notes": self.notes(),
            "gradient_space": [graph.gradient_space.value for graph in self.executed],
            "controllers": [[_node(node) for node in controllers_in(graph)] for graph in self.executed],
            "pipeline": [
                [
                    {"step": i, **_step(step, shape)}
                    for i, (step, shape) in enumerate(zip(made.steps, shapes, strict=True))
                ]
                for made, shapes in zip(self.pipelines, self.shapes, strict=True)
            ],
        }

    def notes(self) -> list[str]:
        """What is worth knowing of the formula before it is run."""
        control = self.target.control
        return [str(fact) for graph in self.executed for fact in facts_about(graph, control)]

    def _resources(self) -> list[str]:
        contacts, joints = [*self.target.robot.contacts, "gravity"], list(self.target.robot.joints)
        sets = {
            s.label: s
            for graph in (*self.phase.stages, *self.executed)
            for n in controllers_in(graph)
            for s in _sets(n)
        }
        rows = []
        for label, resources in sets.items():
            if isinstance(resources, JointSet):
                means = [joints[joint] for joint in resources.joints]
            else:
                means = [
                    " + ".join(contacts[c] if w == 1.0 else f"{w:.3g} {contacts[c]}" for c, w in member.weights)
                    for member in resources.members
                ]
            rows.append(f"  {label} = {{{', '.join(means)}}}")
        return rows

    def _pace(self) -> str:
        """How often the pipeline is evaluated, and what a step of it is."""
        rate, backend = f"{self.target.rate:g} times a second", self.target.backend
        compiled = "" if backend is NUMPY else f"; {backend.about} by {backend.name}"
        if self.target.probes:
            return f"once a probe, {rate} for joint displacements{compiled}"
        return f"{rate}, {self.target.world.pace}{compiled}"

    def protected(self) -> list[str]:
        """What is kept of each level from those below it."""
        kept = f"is kept from what is below: {protection(self.target.control)}"
        return [
            f"of {one.controller.potential.symbol} "
            + ("nothing has to be kept from what is below: ◁ is a plain sum" if one.controller in plain else kept)
            for made, plain in zip(self.pipelines, self._plain(), strict=True)
            for one in made.priorities
        ]

    def _plain(self) -> list[set[ControllerNode]]:
        """The controllers of each stage that a ◁ which is a plain sum joins."""
        return [summed_plainly(graph, self.target.control) for graph in self.executed]

    def _stage(self, graph: ControllerGraph, name: str) -> str:
        rows = [f"  {name}"] if len(self.phase.stages) > 1 else []
        rows += _graph(graph, "  ")
        rows.append(f"  command: {graph.gradient_space.value}, {graph.gradient_space.about}")
        return "\n".join(rows)


def explained(program: Program) -> tuple[Explanation, ...]:
    """The explanation of every phase of a program, out of the pipelines that run."""
    observation, target = in_general_position(program.robot), program.target

    def shapes(pipeline: Pipeline) -> tuple[tuple[int, ...], ...]:
        return tuple(np.shape(value) for value in pipeline.values(observation))

    return tuple(
        Explanation(phase, target, phase.executed(target), pipelines, tuple(map(shapes, pipelines)))
        for phase, pipelines in zip(program.phases, program.pipelines(), strict=True)
    )


def _sets(node: ControllerNode) -> list[ContactSet | JointSet]:
    return [node.effector_resources, node.sensor_resources]


def _graph(graph: ControllerGraph, indent: str) -> list[str]:
    if isinstance(graph, Composition):
        return [row for term in reversed(graph.terms) for row in _graph(term, indent)]
    potential, sensor, effector = graph.potential, graph.sensor, graph.effector
    rows = [
        f"{indent}{potential.symbol}  {potential.about} ({potential.source})",
        f"{indent}  senses  {sensor.symbol}({graph.sensor_resources.label})  {sensor.space.about} ({sensor.source})",
        f"{indent}  moves   {effector.symbol}({graph.effector_resources.label})  {effector.about} "
        f"→ {effector.gradient_space.value} ({effector.source})",
    ]
    match graph.reference:
        case ControllerReference(controller):
            rows.append(f"{indent}  reference: {sensor.symbol} displaced by")
            rows += _graph(controller, indent + "    ")
        case VectorReference(label) | SensorReference(label):
            rows.append(f"{indent}  reference: {label}")
    return rows


def _definition(definition: Definition) -> str:
    """``head ≡ body  (Eq. 4.30) what it is for``."""
    body = to_unicode(definition.body) if definition.body else ""
    equation = f"({cited(definition.equation)})" if definition.equation else ""
    said = " ".join(filter(None, (equation, definition.about)))
    return f"  {to_unicode(definition.head)} ≡ {body}" + (f"  {said}" if said else "")


def _step(step: Step, shape: tuple[int, ...]) -> dict[str, Any]:
    """A step as data; ``constants`` are the numbers that its function holds fixed."""
    return {
        "label": step.label,
        "about": step.about,
        "inputs": list(step.inputs),
        "shape": list(shape),
        "constants": [np.asarray(value).tolist() for value in step.constants],
    }


def _node(node: ControllerNode) -> dict[str, Any]:
    return {
        "formula": node.label,
        "potential": node.potential.symbol,
        "task_space": node.potential.space.about,
        "gradient_space": node.gradient_space.value,
        "equations": [node.potential.equation, node.sensor.equation, node.effector.equation],
        "reference": reference_of(node) or None,
    }


def _pipeline_tree(
    pipeline: Pipeline, shapes: tuple[tuple[int, ...], ...], plain: set[ControllerNode], profile: Profile | None
) -> str:
    rows: list[str] = []
    shown: set[int] = set()

    def add(index: int, lead: str, indent: str) -> None:
        step = pipeline.steps[index]
        size = "×".join(str(n) for n in shapes[index]) or "1"
        if index in shown:
            rows.append(f"{lead}[{index}] {step.label} ↑")
            return
        shown.add(index)
        took = f"  {profile.steps[index]:.1f} µs" if profile and step.reading is None else ""
        rows.append(f"{lead}[{index}] {step.label}  {size}  {step.about}{took}")
        for place, part in enumerate(step.inputs):
            last = place == len(step.inputs) - 1
            add(part, f"{indent}{'└─ ' if last else '├─ '}", indent + ("   " if last else "│  "))

    add(pipeline.command, "  ", "  ")
    residuals = {"force_residual": pipeline.force_residual, "moment_residual": pipeline.moment_residual}
    monitored = {measuring(name).symbol: step for name, step in residuals.items()}
    if pipeline.force_error is not None:
        monitored["force error"] = pipeline.force_error
    rows.append("  monitored: " + ", ".join(f"{name} [{step}]" for name, step in monitored.items()))
    certified = [step for one in pipeline.priorities for step in (one.rank, one.sensed, one.effect, one.alone)]
    certified += astuple(pipeline.certificate) if pipeline.certificate else ()
    for step in (*monitored.values(), *certified):
        if step not in shown:
            add(step, "    ", "    ")
    rows += [
        f"  certified: {one.controller.potential.symbol}, {one.controller.sensor.symbol} [{one.sensed}] in {one.unit}: "
        f"how it goes on, against its Jacobian [{one.effect}] by the command without what is below it [{one.alone}]"
        + ("; ◁ is a plain sum, which takes nothing away" if one.controller in plain else "")
        for one in pipeline.priorities
    ]
    reads = [step.label for step in pipeline.steps if step.reading]
    rows.append(f"  {len(pipeline.steps)} steps; read once: {', '.join(reads)}")
    if profile is not None:
        bare, whole = sum(profile.steps[: pipeline.bare]), sum(profile.steps)
        rows.append(f"  steps by numpy: {bare:.0f} µs for the command, {whole - bare:.0f} µs to certify it")
        name, first = pipeline.backend.name, f"the first took {profile.first:.3g} s"
        rows.append(f"  a tick by {name}: {profile.tick:.0f} µs; {first}")
    return "\n".join(rows)
