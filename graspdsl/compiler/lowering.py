"""Controller graph → pipeline: every sensor read once, every shared expression computed once."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from graspdsl.arrays import Array
from graspdsl.basis.resources import ContactSet
from graspdsl.basis.sensors import SENSORS
from graspdsl.basis.spaces import GradientSpace
from graspdsl.compiler import operations
from graspdsl.compiler.graph import (
    Composition,
    ControllerGraph,
    ControllerNode,
    ControllerReference,
    SensorReference,
    VectorReference,
)
from graspdsl.compiler.laws import Laws
from graspdsl.compiler.pipeline import Leak, Pipeline, PipelineBuilder
from graspdsl.compiler.settings import Target
from graspdsl.compiler.transforms import Transforms


@dataclass(frozen=True, slots=True)
class Level:
    """A lowered controller: the steps of its displacement −k∇ and of the Jacobian of its task."""

    label: str
    displacement: int
    task: int


def compile_controller(graph: ControllerGraph, grasp: ContactSet, target: Target) -> Pipeline:
    """The pipeline of a checked controller. ``grasp``: the resources whose residuals are monitored."""
    return _Lowering(grasp, target).pipeline(graph)


class _Lowering:
    def __init__(self, grasp: ContactSet, target: Target) -> None:
        self._grasp, self._target, self._control = grasp, target, target.control
        self._build = PipelineBuilder()
        self._transforms = Transforms(self._build, grasp, target)
        self._laws = Laws(self._build, self._transforms, target)
        self._leaks: list[Leak] = []

    def pipeline(self, graph: ControllerGraph) -> Pipeline:
        command = self._motion(graph)
        by_contact = {GradientSpace.SURFACE: operations.by_surface, GradientSpace.CARTESIAN: operations.by_contact}
        if graph.gradient_space in by_contact:
            command = self._build.apply("Δ(γ)", "displacement, by contact", by_contact[graph.gradient_space], command)
        force_residual = self._transforms.sensor(SENSORS["σ_fr"], self._grasp)
        moment_residual = self._transforms.sensor(SENSORS["σ_mr"], self._grasp)
        outputs = [command, force_residual, moment_residual, *[leak.step for leak in self._leaks]]
        steps, number = self._build.needed(outputs)
        return Pipeline(
            steps=steps,
            command=number[command],
            space=graph.gradient_space.value,
            force_residual=number[force_residual],
            moment_residual=number[moment_residual],
            leaks=tuple(replace(leak, step=number[leak.step]) for leak in self._leaks),
        )

    def _motion(self, graph: ControllerGraph) -> int:
        """The displacement of a whole controller, scaled back from the coordinates it was worked out in."""
        space = graph.gradient_space
        joints = space is GradientSpace.JOINTS
        scale = np.array(self._target.robot.weights) if joints else self._transforms.contact_scale(space)
        unscale = partial(np.multiply, scale)
        about = f"{space.about}, scaled back"
        return self._build.apply(f"Δ{space.value}", about, unscale, self._level(graph).displacement)

    def _level(self, graph: ControllerGraph) -> Level:
        return self._composition(graph) if isinstance(graph, Composition) else self._controller(graph)

    def _composition(self, graph: Composition) -> Level:
        """∇hi + N ∇lo for any depth: each level runs in the null space of all higher ones at once (Eq. 4.19)."""
        by_task = self._control.nullspace == "task"
        project = operations.task_projector if by_task else operations.gradient_projector
        highest, *lower = (self._level(term) for term in reversed(graph.terms))
        above, total = [highest], highest.displacement
        for level in lower:
            felt = [higher.task if by_task else higher.displacement for higher in above]
            names = ", ".join(("τ " if by_task else "∇") + higher.label for higher in above)
            projector = self._build.apply(
                f"N({names})", "projector on the null space of what is higher", project, *felt
            )
            projected = self._build.apply(
                f"N Δ{level.label}", "the lower level, projected", operations.times, projector, level.displacement
            )
            for higher, step in zip(above, felt, strict=True):
                self._certify(level, higher, step, projected)
            total = self._build.apply("Σ", "higher levels + projected lower level, Eq. 4.19", np.add, total, projected)
            above.append(level)
        tasks = [level.task for level in above]
        task = self._build.apply("τ", "the tasks of all levels", operations.stacked, *tasks)
        return Level(f"({' ◁ '.join(level.label for level in reversed(above))})", total, task)

    def _certify(self, lower: Level, higher: Level, felt: int, projected: int) -> None:
        measure = operations.leak if self._control.nullspace == "task" else operations.gradient_leak
        label = f"leak {lower.label} → {higher.label}"
        step = self._build.apply(
            label, "share of the lower level that the higher one feels", measure, felt, lower.displacement, projected
        )
        self._leaks.append(Leak(lower.label, higher.label, step))

    def _controller(self, node: ControllerNode) -> Level:
        name = node.potential.symbol
        error = self._error(node)
        about = f"gradient of the potential, Eq. {node.potential.equation}"
        slope = self._build.apply(f"∇{name}", about, node.potential.gradient, error)
        task = self._transforms.effector(node.effector, node.effector_resources)
        return Level(name, self._laws.displacement(node, slope, task), task)

    def _error(self, node: ControllerNode) -> int:
        """reference − sensed, flattened; a controller without a reference strives for zero."""
        build, resources = self._build, node.sensor_resources
        sensed = self._transforms.sensor(node.sensor, resources)
        label = f"e {node.potential.symbol}"
        match node.reference:
            case None:
                return build.apply(label, "error: zero − sensed", np.negative, sensed)
            case VectorReference(name, values):
                return self._vector_error(node, label, name, np.array(values).reshape(-1, 3))
            case SensorReference(name, factor, sensor, set_of_reference):
                value = self._transforms.sensor(sensor, set_of_reference)
                value = build.apply(name, "reference", partial(np.multiply, factor), value)
            case ControllerReference(controller):
                cap = partial(operations.capped, self._control.cap)
                moved = build.apply("Δx", "contact displacements, capped", cap, self._motion(controller))
                rows = partial(operations.rows_of, self._transforms.mixing(resources))
                shift = build.apply(f"Δx({resources.label})", "displacement by resource", rows, moved)
                value = build.apply("x_ref", "reference: sensed + displacement", np.add, sensed, shift)
        error = build.apply(label, "error: reference − sensed", np.subtract, value, sensed)
        return build.apply(label, "flattened", operations.flat, error)

    def _vector_error(self, node: ControllerNode, label: str, name: str, values: Array) -> int:
        """Reference minus the resources' means; the members of a virtual contact share its error."""
        build, resources = self._build, node.sensor_resources
        value = build.constant(name, "reference", values)
        means = self._transforms.sensor(node.sensor, resources, resources.matrix)
        error = build.apply(label, "error: reference − sensed", np.subtract, value, means)
        if self._control.virtual == "members":
            owner = np.repeat(np.arange(len(resources.members)), [len(member.weights) for member in resources.members])
            spread = np.eye(len(resources.members))[owner]
            error = build.apply(label, "error of each member", partial(np.matmul, spread), error)
        return build.apply(label, "flattened", operations.flat, error)
