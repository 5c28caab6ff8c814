"""Controller graph → pipeline: every sensor read once, every shared expression computed once."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from graspdsl.basis.resources import ContactSet
from graspdsl.basis.sensors import SENSORS
from graspdsl.basis.spaces import GradientSpace, TaskSpace
from graspdsl.compiler import operations
from graspdsl.compiler.citing import cited
from graspdsl.compiler.errors import Errors
from graspdsl.compiler.graph import Composition, ControllerGraph, ControllerNode
from graspdsl.compiler.laws import Laws
from graspdsl.compiler.pipeline import Leak, Pipeline, PipelineBuilder, Projection
from graspdsl.compiler.settings import Target
from graspdsl.compiler.transforms import Transforms


@dataclass(frozen=True, slots=True)
class Level:
    """A lowered controller: the steps of its displacement −k∇ and of the Jacobian of its task.

    ``within``: the levels of a chain that stands in brackets or behind a name; what is lower must spare each of them.
    """

    label: str
    displacement: int
    task: int
    within: tuple[Level, ...] = ()

    @property
    def single(self) -> tuple[Level, ...]:
        """The levels without chains: those within, or this one."""
        return self.within or (self,)


def compile_controller(graph: ControllerGraph, grasp: ContactSet, target: Target) -> Pipeline:
    """The pipeline of a checked controller. ``grasp``: the resources whose residuals are monitored."""
    return _Lowering(grasp, target).pipeline(graph)


class _Lowering:
    def __init__(self, grasp: ContactSet, target: Target) -> None:
        self._grasp, self._target, self._control = grasp, target, target.control
        self._build = PipelineBuilder()
        self._transforms = Transforms(self._build, grasp, target)
        self._errors = Errors(self._build, self._transforms, target, self._motion)
        self._laws = Laws(self._build, self._transforms, grasp, target)
        self._leaks: list[Leak] = []
        self._ranks: list[int] = []
        self._projections: list[Projection] = []
        self._force_errors: list[int] = []

    def pipeline(self, graph: ControllerGraph) -> Pipeline:
        space, command = graph.gradient_space, self._motion(graph)
        if space is GradientSpace.SURFACE:
            frames, radius = self._transforms.read("frames"), self._transforms.read("curvature_radius")
            by_surface = self._build.apply("Δψ(γ)", "by contact", operations.by_surface, command)
            about = "displacement of the contacts [m], Eq. 4.27"
            command = self._build.apply("Δx", about, operations.from_surface, frames, radius, by_surface)
        elif space is GradientSpace.CARTESIAN:
            command = self._build.apply("Δx", "by contact", operations.by_contact, command)
        if space in (GradientSpace.SURFACE, GradientSpace.CARTESIAN):
            cap = partial(operations.capped_rows, self._target.cap)
            about = f"capped at {1000 * self._target.cap:.3g} mm a {self._target.each}"
            command = self._build.apply("Δx", about, cap, command)
        force_residual = self._transforms.sensor(SENSORS["σ_fr"], self._grasp)
        moment_residual = self._transforms.sensor(SENSORS["σ_mr"], self._grasp)
        outputs = [command, force_residual, moment_residual, *[leak.step for leak in self._leaks], *self._ranks]
        force_error = self._largest_force_error()
        outputs += [] if force_error is None else [force_error]
        steps, number = self._build.needed(outputs)
        return Pipeline(
            steps=steps,
            command=number[command],
            space="x" if space is GradientSpace.SURFACE else space.value,
            force_residual=number[force_residual],
            moment_residual=number[moment_residual],
            leaks=tuple(replace(leak, step=number[leak.step]) for leak in self._leaks),
            ranks=tuple(number[rank] for rank in self._ranks),
            projections=tuple(
                replace(found, before=number[found.before], after=number[found.after]) for found in self._projections
            ),
            force_error=None if force_error is None else number[force_error],
            limits=self._target.limits if space is GradientSpace.JOINTS else None,
        )

    def _largest_force_error(self) -> int | None:
        if not self._force_errors:
            return None
        largest, *others = self._force_errors
        for other in others:
            largest = self._build.apply("max", "of all force controllers [N]", np.maximum, largest, other)
        return largest

    def _motion(self, graph: ControllerGraph) -> int:
        """The displacement of a whole controller; joints are scaled back from their working coordinates."""
        displacement = self._level(graph).displacement
        if graph.gradient_space is not GradientSpace.JOINTS:
            return displacement
        unscale = partial(np.multiply, np.array(self._target.robot.weights))
        return self._build.apply("Δq", f"{graph.gradient_space.about}, scaled back", unscale, displacement)

    def _level(self, graph: ControllerGraph) -> Level:
        return self._composition(graph) if isinstance(graph, Composition) else self._controller(graph)

    def _composition(self, graph: Composition) -> Level:
        """∇hi + N ∇lo for any depth: each level runs in the null space of all higher ones at once (Eq. 4.19)."""
        by_task = self._control.nullspace == "task"
        project = operations.task_projector if by_task else operations.gradient_projector
        highest, *lower = (self._level(term) for term in reversed(graph.terms))
        above, total = list(highest.single), highest.displacement
        for level in lower:
            felt = [higher.task if by_task else higher.displacement for higher in above]
            names = ", ".join(("τ " if by_task else "∇") + higher.label for higher in above)
            projector = self._build.apply(
                f"N({names})", "projector on the null space of what is higher", project, *felt
            )
            projected = self._build.apply(
                f"N Δ{level.label}", "the lower level, projected", operations.times, projector, level.displacement
            )
            self._ranks.append(self._build.apply("rank", "dimension of the null space", operations.rank, projector))
            labels = tuple(higher.label for higher in above)
            self._projections.append(Projection(level.label, labels, level.displacement, projected))
            for higher, step in zip(above, felt, strict=True):
                self._certify(level, higher, step, projected)
            total = self._build.apply("Σ", "higher levels + projected lower level, Eq. 4.19", np.add, total, projected)
            above += level.single
        tasks = [level.task for level in above]
        task = self._build.apply("τ", "the tasks of all levels", operations.stacked, *tasks)
        label = f"({' ◁ '.join(level.label for level in reversed(above))})"
        return Level(label, total, task, tuple(above))

    def _certify(self, lower: Level, higher: Level, felt: int, projected: int) -> None:
        measure = operations.leak if self._control.nullspace == "task" else operations.gradient_leak
        label = f"leak {lower.label} → {higher.label}"
        step = self._build.apply(
            label, "share of the lower level that the higher one feels", measure, felt, lower.displacement, projected
        )
        self._leaks.append(Leak(lower.label, higher.label, step))

    def _controller(self, node: ControllerNode) -> Level:
        name = node.potential.symbol
        error = self._errors.error(node)
        if node.potential.space is TaskSpace.FORCE:
            about = "largest distance of a contact force from its reference [N]"
            self._force_errors.append(self._build.apply("max |e φ_f|", about, operations.longest, error))
        about = f"gradient of the potential, {cited(node.potential.equation)}"
        slope = self._build.apply(f"∇{name}", about, node.potential.gradient, error)
        task = self._transforms.effector(node.effector, node.effector_resources, node.sensor_resources)
        return Level(name, self._laws.displacement(node, slope, task), task)
