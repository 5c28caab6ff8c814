"""Controller graph → pipeline: every sensor read once, every shared expression computed once."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import astuple, dataclass, replace
from functools import partial

import numpy as np

from graspdsl.arrays import Array, product
from graspdsl.basis import operations
from graspdsl.basis.algebra import spherical_frames, spherical_stretch, tangent_frames, tangent_planes
from graspdsl.basis.effectors import Effector, sphere_by_cartesian
from graspdsl.basis.laws import Slope
from graspdsl.basis.potentials import STRAIGHT, Difference
from graspdsl.basis.resources import ContactSet, JointSet
from graspdsl.basis.sensors import Sensor, measuring
from graspdsl.basis.spaces import GradientSpace
from graspdsl.compiler.graph import (
    Composition,
    ControllerGraph,
    ControllerNode,
    ControllerReference,
    SensorReference,
    VectorReference,
)
from graspdsl.compiler.pipeline import (
    LOCKED,
    Certificate,
    Pipeline,
    PipelineBuilder,
    Priority,
    Projection,
    steps_between,
)
from graspdsl.compiler.settings import Target
from graspdsl.diagnostics import listed
from graspdsl.hands.descriptions import joint_limits

READINGS = {
    "points": "contact points [m]",
    "normals": "inward unit normals",
    "forces": "contact forces [N]",
    "touching": "which contacts touch",
    "joints": "joint positions [m or rad]",
    "orientations": "fingertip orientations [rad]",
    "centre_of_mass": "the object's centre of mass [m]",
    "weight": "the object's weight [N]",
}
DOWN = np.array([0.0, 0.0, -1.0])


@dataclass(frozen=True, slots=True)
class NullSpace:
    """How the null space of higher levels is told: what is ``made_of`` all that is felt of them, what that leaves of a
    lower displacement, and its dimension."""

    about: str
    made_of: Callable[..., Array]
    left_of: Callable[[Array, Array], Array]
    rank: Callable[[Array], Array]


OF_TASKS = NullSpace(
    "projector on the null space of what is higher", operations.task_projector, operations.times, operations.rank
)
OF_GRADIENTS = NullSpace(
    "directions of what is higher, which leave what is across",
    *(operations.directions, operations.across, operations.rank_across),
)


@dataclass(frozen=True, slots=True)
class Level:
    """A lowered controller, or a chain of them: the steps of its displacement −k∇ and of the Jacobian of its task.

    ``single``: the levels of a chain, highest first, of which what is lower must spare each; ``sums``: their
    displacements, each with all above it; ``ranks``: of the null spaces below all but the last.
    """

    label: str
    displacement: int
    task: int
    single: tuple[SingleLevel, ...]
    sums: tuple[int, ...]
    ranks: tuple[int, ...] = ()


@dataclass(frozen=True, slots=True)
class SingleLevel:
    """A lowered controller: the steps of its displacement −k∇ and of the Jacobian of its task."""

    controller: ControllerNode
    displacement: int
    task: int

    @property
    def label(self) -> str:
        """As its potential is written."""
        return self.controller.potential.symbol


def compile_controller(graph: ControllerGraph, grasp: ContactSet, target: Target) -> Pipeline:
    """The pipeline of a checked controller. ``grasp``: the resources whose residuals are monitored."""
    return _Lowering(_Bench(grasp, target)).pipeline(graph)


class _Bench(PipelineBuilder):
    """Makes the steps of sensor and effector transforms over resource sets, and what laws ask for.

    Joints are worked with in scaled coordinates, each divided by its weight, so that metres and radians weigh alike in
    transposes, inverses and projectors.
    """

    def __init__(self, grasp: ContactSet, target: Target) -> None:
        super().__init__()
        self.grasp, self.target, self.control = grasp, target, target.control
        self.rate, self.each, self.held = target.rate, target.each, target.held
        self.transposes = self.control.inverse == "transpose"
        self.step = target.step(float(grasp.weights @ grasp.weights))

    def setting(self, key: str) -> float:
        number: float = getattr(self.control, key)
        return number

    def mixing(self, resources: ContactSet) -> Array:
        """The rows (m, k) of per-contact tasks: one a member of a virtual contact, or one a resource (their mean)."""
        if self.control.virtual == "common":
            return resources.matrix
        chosen = [contact for member in resources.members for contact, _ in member.weights]
        rows: Array = np.eye(resources.matrix.shape[1])[chosen]
        return rows

    def shares(self, resources: ContactSet) -> Array:
        """The share (m,) of what is asked of its resource that each row of :meth:`mixing` has."""
        if self.control.virtual == "common":
            return resources.shares
        return np.array([weight for member in resources.members for _, weight in member.weights])

    def fingers(self, resources: ContactSet) -> Array:
        robot = self.target.robot
        return np.array(
            [
                [float(index in resources.contacts and joint in contact.finger) for joint in robot.joints]
                for index, contact in enumerate(robot.hand.contacts.values())
            ]
        )

    def sensor(self, sensor: Sensor, resources: ContactSet | JointSet, mixing: Array | None = None) -> int:
        """σ(Γ); ``mixing`` overrules the rows that the control settings ask for."""
        if mixing is None:
            mixing = self._rows(sensor, resources)
        with_gravity = isinstance(resources, ContactSet) and resources.has_gravity
        return self.apply(
            f"{sensor.symbol}({resources.label})",
            f"{sensor.about}, {sensor.source}",
            partial(sensor.evaluate, mixing),
            *[self._read_with_gravity(name) if with_gravity else self.read(name) for name in sensor.reads],
        )

    def _rows(self, sensor: Sensor, resources: ContactSet | JointSet) -> Array:
        if isinstance(resources, JointSet):
            return resources.matrix
        return self.mixing(resources) if sensor.per_contact else resources.weights

    def effector(self, effector: Effector, resources: ContactSet | JointSet, sensed: ContactSet | JointSet) -> int:
        """τ(Γτ) of a controller that senses ``sensed``, in joint space with a row for each of its rows."""
        space, label = effector.gradient_space, f"{effector.symbol}({resources.label})"
        step = self._transform(effector, resources, sensed)
        shared = self.control.virtual == "common" and isinstance(resources, ContactSet) and resources.has_virtual
        if space in (GradientSpace.ROTATION, GradientSpace.JOINTS) or not shared:
            return step
        assert isinstance(resources, ContactSet)
        together = (resources.matrix > 0.0).astype(float)
        about, sharing = "members of a virtual contact move as one, Eq. 4.34", together.T @ together
        if space is GradientSpace.SURFACE and self.control.surface == "tangent":
            share = partial(operations.shared_along_frames, sharing)
            return self.apply(label, about, share, step, self.read("frames"))
        return self.apply(label, about, partial(operations.shared, sharing), step)

    def pullback(self, effector: Effector, task: int, label: str, about: str, vector: int) -> int:
        """τᵀ times a vector (..., d), of the step of an effector transform: where that has a way to it without τ, and
        no contacts share a motion, by that."""
        made = self.steps[task]
        known = isinstance(made.function, partial) and made.function.func == effector.evaluate
        if not known or type(effector).pullback is Effector.pullback:
            return self.apply(label, about, operations.transposed_times, task, vector)
        return self.apply(label, about, partial(effector.pullback, *made.constants), vector, *made.inputs)

    def effect(self, controller: ControllerNode, space: GradientSpace) -> int:
        """The Jacobian of what a controller senses by what a pipeline of a space commands, (..., d, D).

        Whatever moves it counts, also contacts that the controller itself leaves alone: τ(Γσ).
        """
        effector, sensed, label = controller.effector, controller.sensor_resources, f"∂{controller.sensor.symbol}"
        step = self._transform(effector, sensed, sensed)
        match effector.gradient_space:
            case GradientSpace.JOINTS:
                scale = partial(np.multiply, 1.0 / np.array(self.target.robot.weights))
                return self.apply(label, "by the joints, scaled back", scale, step)
            case GradientSpace.SURFACE:
                frames, radius = self.read("frames"), self.read("curvature_radius")
                return self.apply(label, "by contact displacements", operations.by_displacement, step, frames, radius)
            case GradientSpace.CARTESIAN if space is GradientSpace.JOINTS:
                moved = self.observe("jacobian", "Jacobians of the contacts")
                return self.apply(label, "by the joints, as they move the contacts", operations.by_joints, step, moved)
            case GradientSpace.ROTATION if space is GradientSpace.JOINTS:
                assert isinstance(controller.effector_resources, ContactSet)
                weights = controller.effector_resources.weights
                mean = partial(operations.by_turning, weights / weights.sum())
                turned = self._held_still("J_ω", self.observe("angular_jacobian", "angular Jacobians of the contacts"))
                return self.apply(label, "by the joints, as they turn the object", mean, step, turned)
        return step

    def _held_still(self, label: str, jacobian: int) -> int:
        """A Jacobian by the joints that may turn a held object."""
        turning = partial(np.multiply, np.array(self.target.turning_joints, dtype=float))
        return self.apply(label, "the fingers hold still", turning, jacobian)

    def _transform(self, effector: Effector, resources: ContactSet | JointSet, sensed: ContactSet | JointSet) -> int:
        """τ(Γτ) with contacts that move each by itself."""
        space = effector.gradient_space
        label, with_gravity = f"{effector.symbol}({resources.label})", False
        if isinstance(resources, JointSet):
            assert isinstance(sensed, JointSet)
            mixing = sensed.matrix * resources.mask
        elif space is GradientSpace.ROTATION:
            assert isinstance(sensed, ContactSet)
            mixing, with_gravity = sensed.turning, sensed.has_gravity
        elif effector.weighs_sensed:
            assert isinstance(sensed, ContactSet)
            assert isinstance(resources, ContactSet)
            mixing, with_gravity = sensed.beside(resources), sensed.has_gravity
        else:
            assert isinstance(sensed, ContactSet)
            mixing = self.mixing(sensed) if space is GradientSpace.JOINTS else resources.weights[: resources.count]
        step = self.apply(
            label,
            f"{effector.about}, {effector.source}",
            partial(effector.evaluate, mixing),
            *[self._read_with_gravity(name) if with_gravity else self.read(name) for name in effector.reads],
        )
        if self.held and "angular_jacobian" in effector.reads:
            return self._held_still(label, step)
        return step

    def read(self, name: str) -> int:
        """A field of the observation, or a quantity made of one."""
        match name:
            case "jacobian" | "angular_jacobian":
                turning = "angular " if name == "angular_jacobian" else ""
                raw = self.observe(name, f"{turning}Jacobians of the contacts")
                scale = partial(np.multiply, np.array(self.target.robot.weights))
                return self.apply("J", f"{turning}Jacobians in scaled joint coordinates", scale, raw)
            case "joint_weights":
                return self.constant("D", "joint weights", np.array(self.target.robot.weights))
            case "curvature_radius":
                radius = np.array(self.control.curvature_radius)
                return self.constant("r", f"radius of the model sphere, {radius:g} m", radius)
            case "into":
                about = "motion of each contact along its normal, by scaled joint coordinates"
                moved = (self.read("jacobian"), self.read("normals"))
                return self.apply("nᵀJ", about, operations.transposed_times, *moved)
            case "tangents" if self.control.surface == "spherical":
                about = "how displacements turn normals, T S Tᵀ"
                return self.apply("∂n̂/∂x", about, sphere_by_cartesian, self.read("frames"), self.read("stretch"))
            case "tangents":
                return self.apply("I − n nᵀ", "projectors on the tangent planes", tangent_planes, self.read("normals"))
            case "frames":
                frames = spherical_frames if self.control.surface == "spherical" else tangent_frames
                return self.apply("(r̂_θ r̂_φ)", "frames of the tangent planes", frames, self.read("normals"))
            case "stretch" if self.control.surface == "spherical":
                return self.apply("(cosφ, 1)", "stretch of the coordinates", spherical_stretch, self.read("normals"))
            case "stretch":
                return self.constant("(1, 1)", "stretch of the coordinates: none", np.ones((self.grasp.count, 2)))
            case "origin":
                return self._origin()
            case "origin_shares":
                own = self.control.origin == "centroid"
                shares = self.grasp.weights[: self.grasp.count] * (own / self.grasp.weights.sum())
                return self.constant("∂c/∂x", "how the origin of moments goes with each contact", shares)
            case "shape_operators":
                about = "how outward normals turn as contacts slide [1/m]"
                if self.target.surface is not None:
                    return self.apply("S", about, self.target.surface.shape_operators, self.read("points"))
                model = (self.read("normals"), self.read("curvature_radius"))
                return self.apply("S", f"{about}, of the model sphere", operations.of_the_model_sphere, *model)
        return self.observe(name, READINGS[name])

    def _read_with_gravity(self, name: str) -> int:
        """A reading over the contacts and, last, gravity (Eq. 4.35 to 4.37)."""
        match name:
            case "points":
                last, about = self.read("centre_of_mass"), "contact points and the centre of mass, Eq. 4.35"
            case "forces":
                last, about = self.read("weight"), "contact forces and the weight, Eq. 4.36"
            case "normals":
                last, about = self.constant("γ_g", "down", DOWN), "normals and down, Eq. 4.37"
            case _:
                return self.read(name)
        return self.apply(f"{name}, γ_g", about, operations.with_last_row, self.read(name), last)

    def _origin(self) -> int:
        match self.control.origin:
            case "world":
                return self.constant("c", "origin of moments: the world's", np.zeros(3))
            case "object":
                return self.apply("c", "origin of moments: the object's", operations.same, self.read("centre_of_mass"))
        mean = partial(product, self.grasp.weights / self.grasp.weights.sum())
        points = self._read_with_gravity("points") if self.grasp.has_gravity else self.read("points")
        return self.apply("c", "origin of moments: centroid of the contacts", mean, points)


class _Lowering:
    def __init__(self, bench: _Bench) -> None:
        self._bench, self._target, self._control = bench, bench.target, bench.control
        self._chains: list[Level] = []
        self._excesses: list[int] = []
        self._projections: list[Projection] = []
        self._force_errors: list[int] = []

    def pipeline(self, graph: ControllerGraph) -> Pipeline:
        """All steps from what is read to the command and to what is monitored."""
        bench, space, command = self._bench, graph.gradient_space, self._motion(graph)
        if space is GradientSpace.SURFACE:
            frames, radius = bench.read("frames"), bench.read("curvature_radius")
            by_surface = bench.apply("Δψ(γ)", "by contact", operations.by_surface, command)
            about = "displacement of the contacts [m], Eq. 4.27"
            command = bench.apply("Δx", about, operations.from_surface, frames, radius, by_surface)
            command = bench.apply("Δx", "flattened", operations.flat, command)
        if space in (GradientSpace.SURFACE, GradientSpace.CARTESIAN):
            command = bench.apply("Δx", "by contact", operations.by_contact, self._capped(STRAIGHT, command))
        force_residual = bench.sensor(measuring("force_residual"), bench.grasp)
        moment_residual = bench.sensor(measuring("moment_residual"), bench.grasp)
        priorities = [priority for chain in self._chains for priority in self._priorities(chain, command, space)]
        outputs = [command, force_residual, moment_residual, *(priority.rank for priority in priorities)]
        force_error = self._largest_force_error()
        outputs += [] if force_error is None else [force_error]
        certificate = self._certificate(priorities, command, space) if priorities else None
        steps, number = bench.needed(outputs, astuple(certificate) if certificate else ())
        moving = [command, *(step for one in priorities for step in (one.alone, one.rank))]
        return Pipeline(
            steps=steps,
            command=number[command],
            space="x" if space is GradientSpace.SURFACE else space.value,
            force_residual=number[force_residual],
            moment_residual=number[moment_residual],
            priorities=tuple(
                Priority(
                    one.controller,
                    **{name: number[getattr(one, name)] for name in ("sensed", "effect", "alone", "shortened", "rank")},
                )
                for one in priorities
            ),
            certificate=certificate and Certificate(*(number[step] for step in astuple(certificate))),
            bare=len(bench.needed(outputs)[0]),
            projections=tuple(
                replace(found, before=number[found.before], after=number[found.after]) for found in self._projections
            ),
            force_error=None if force_error is None else number[force_error],
            limits=self._target.limits if space is GradientSpace.JOINTS else None,
            backend=self._target.backend,
            locked=steps_between(steps, LOCKED, [number[step] for step in moving]),
        )

    def _certificate(self, priorities: Sequence[Priority], command: int, space: GradientSpace) -> Certificate:
        """What is told of the levels, one beside the other."""
        bench = self._bench

        def flat(label: str, step: int, is_flat: bool) -> int:
            return step if is_flat else bench.apply(label, "flattened", operations.flat, step)

        sensors = [(one.controller.sensor, one.sensed) for one in priorities]
        sensed = [flat(sensor.symbol, step, not sensor.per_contact) for sensor, step in sensors]
        changes = []
        for one in priorities:
            effect, *moved = one.told_by(command)
            moved = [flat("Δx", step, space is GradientSpace.JOINTS) for step in moved]
            label, about = f"Δ{one.controller.sensor.symbol}", "what it changes by itself, and what the others change"
            changes.append(bench.apply(label, about, operations.changes, effect, *moved))
        side = operations.side_by_side
        return Certificate(
            sensed=bench.apply("σ", "what the levels sense", partial(side, 1, -1), *sensed),
            effects=bench.apply("∂σ", "their Jacobians", partial(side, 2, -2), *(one.effect for one in priorities)),
            changes=bench.apply("Δσ", "what changes them, by causes", partial(side, 2, -1), *changes),
        )

    def _priorities(self, chain: Level, command: int, space: GradientSpace) -> Iterator[Priority]:
        """The levels of a chain that others are subject to, with what each alone would have made of the command."""
        bench, fixed = self._bench, {excess: excess for excess in self._excesses}
        for level, above, rank in zip(chain.single, chain.sums, chain.ranks, strict=False):
            controller, alone = level.controller, {chain.displacement: above}
            yield Priority(
                controller,
                sensed=bench.sensor(controller.sensor, controller.sensor_resources),
                effect=bench.effect(controller, space),
                alone=bench.instead(command, alone),
                shortened=bench.instead(command, alone | fixed),
                rank=rank,
            )

    def _largest_force_error(self) -> int | None:
        if not self._force_errors:
            return None
        largest, *others = self._force_errors
        for other in others:
            largest = self._bench.apply("max", "of all force controllers [N]", np.maximum, largest, other)
        return largest

    def _motion(self, graph: ControllerGraph) -> int:
        """The displacement of a whole controller; joints are scaled back from their working coordinates."""
        chain = self._level(graph)
        self._chains.append(chain)
        displacement = chain.displacement
        if graph.gradient_space is not GradientSpace.JOINTS:
            return displacement
        unscale = partial(np.multiply, np.array(self._target.robot.weights))
        return self._bench.apply("Δq", f"{graph.gradient_space.about}, scaled back", unscale, displacement)

    def _level(self, graph: ControllerGraph) -> Level:
        return self._composition(graph) if isinstance(graph, Composition) else self._controller(graph)

    def _composition(self, graph: Composition) -> Level:
        """∇hi + N ∇lo for any depth: each level runs in the null space of all higher ones at once (Eq. 4.19)."""
        bench, by_task = self._bench, self._control.nullspace == "task"
        null_space = OF_TASKS if by_task else OF_GRADIENTS
        highest, *lower = (self._level(term) for term in reversed(graph.terms))
        above, total, sums, ranks = list(highest.single), highest.displacement, [*highest.sums], [*highest.ranks]
        for level in lower:
            felt = [higher.task if by_task else higher.displacement for higher in above]
            names = ", ".join(("τ " if by_task else "∇") + higher.label for higher in above)
            projector = bench.apply(f"N({names})", null_space.about, null_space.made_of, *felt)
            ranks.append(bench.apply("rank", "dimension of the null space", null_space.rank, projector))
            labels = tuple(higher.label for higher in above)
            for part in level.sums:
                about = "the lower level, projected"
                projected = bench.apply(f"N Δ{level.label}", about, null_space.left_of, projector, part)
                about = "higher levels + projected lower level, Eq. 4.19"
                sums.append(bench.apply("Σ", about, np.add, total, projected))
            self._projections.append(Projection(level.label, labels, level.displacement, projected))
            total = sums[-1]
            above += level.single
            ranks += level.ranks
        task = bench.apply("τ", "the tasks of all levels", operations.stacked, *(level.task for level in above))
        label = f"({' ◁ '.join(level.label for level in reversed(above))})"
        return Level(label, total, task, tuple(above), tuple(sums), tuple(ranks))

    def _controller(self, node: ControllerNode) -> Level:
        bench, potential = self._bench, node.potential
        error = self._error(node)
        if "force_error" in potential.lowers:
            about = "largest distance of a contact force from its reference [N]"
            self._force_errors.append(bench.apply(f"max |e {potential.symbol}|", about, operations.longest, error))
        about = f"gradient of the potential, {potential.source}"
        gradient = bench.apply(f"∇{potential.symbol}", about, potential.gradient, error)
        task = bench.effector(node.effector, node.effector_resources, node.sensor_resources)
        pullback = partial(bench.pullback, node.effector, task)
        slope = Slope(
            potential.symbol, potential.source, node.effector, node.effector_resources, gradient, task, pullback
        )
        displacement = potential.law.displacement(bench, slope)
        return Level(potential.symbol, displacement, task, (SingleLevel(node, displacement, task),), (displacement,))

    # --- errors: what a controller strives for minus what it senses ---------------------------------------------------

    def _error(self, node: ControllerNode) -> int:
        """reference − sensed, flattened; a controller without a reference strives for zero or for its default."""
        bench, resources, difference = self._bench, node.sensor_resources, node.potential.difference
        sensed = bench.sensor(node.sensor, resources)
        label = f"e {node.potential.symbol}"
        if isinstance(resources, JointSet):
            return bench.apply(label, "error: reference − sensed", np.subtract, self._posture(node, resources), sensed)
        match node.reference:
            case None:
                return bench.apply(label, "error: zero − sensed", np.negative, sensed)
            case VectorReference(name, values):
                return self._from_vector(node, resources, name, np.array(values).reshape(-1, 3))
            case SensorReference(name, factor, sensor, set_of_reference):
                value = bench.sensor(sensor, set_of_reference)
                value = bench.apply(name, "reference", partial(np.multiply, factor), value)
                if sensor.makes_forces and isinstance(set_of_reference, ContactSet):
                    value = self._shared(node, name, bench.shares(set_of_reference), value)
            case ControllerReference(controller):
                shift = self._shift(controller, resources, difference)
                value = bench.apply("ref", "reference: sensed + displacement", difference.displaced, shift, sensed)
        error = bench.apply(label, "error: reference − sensed", difference.between, value, sensed)
        return bench.apply(label, "flattened", operations.flat, error)

    def _shared(self, node: ControllerNode, name: str, shares: Array, reference: int) -> int:
        """The reference, of which members of virtual contacts press their shares where the control settings say so."""
        if not (node.potential.adds_up and self._control.virtual_forces == "shared") or (shares == 1.0).all():
            return reference
        about = f"members of a virtual contact press their shares of it: × {listed(f'{share:.3g}' for share in shares)}"
        return self._bench.apply(f"w {name}", about, partial(np.multiply, shares[:, None]), reference)

    def _shift(self, controller: ControllerGraph, resources: ContactSet, difference: Difference) -> int:
        """One step of the controller in the reference, by resource, capped."""
        moved = self._capped(difference, self._motion(controller))
        mixing = self._bench.mixing(resources)
        rows = partial(operations.rows_of, np.ones((len(mixing), 1)) if difference.turns else mixing)
        return self._bench.apply(f"{difference.label}({resources.label})", "by resource", rows, moved)

    def _from_vector(self, node: ControllerNode, resources: ContactSet, name: str, values: Array) -> int:
        """Reference minus the resources' means; the members of a virtual contact share its error."""
        bench, potential, label = self._bench, node.potential, f"e {node.potential.symbol}"
        value = bench.constant(name, "reference", values)
        value = self._shared(node, name, resources.shares, value)
        means = bench.sensor(node.sensor, resources, resources.matrix)
        error = bench.apply(label, "error: reference − sensed", potential.difference.between, value, means)
        if self._control.virtual == "members":
            owner = np.repeat(np.arange(len(resources.members)), [len(member.weights) for member in resources.members])
            spread = np.eye(len(resources.members))[owner]
            error = bench.apply(label, "error of each member", partial(product, spread), error)
        error = bench.apply(label, "flattened", operations.flat, error)
        if potential.is_capped:
            error = self._capped(potential.difference, error, label)
        return error

    def _capped(self, difference: Difference, moved: int, label: str = "") -> int:
        """Displacements, shortened to the cap; a turn moves contacts at the curvature radius."""
        cap = self._target.cap * (1.0 / self._control.curvature_radius if difference.turns else 1.0)
        size = f"{cap:.3g} rad" if difference.turns else f"{1000 * cap:.3g} mm"
        label, about = label or difference.label, f"capped at {size} a {self._target.each}"
        excess = self._bench.apply(f"|{label}| / cap", "at least one", partial(operations.excess, cap), moved)
        self._excesses.append(excess)
        return self._bench.apply(label, about, operations.shortened, moved, excess)

    def _posture(self, node: ControllerNode, joints: JointSet) -> int:
        match node.reference:
            case VectorReference(name, values):
                return self._bench.constant(name, "reference posture", np.array(values))
            case SensorReference(name, factor, sensor, set_of_reference):
                value = self._bench.sensor(sensor, set_of_reference)
                return self._bench.apply(name, "reference posture", partial(np.multiply, factor), value)
        lower, upper = joint_limits(self._target.robot)
        middle = joints.matrix @ (np.array(lower) + np.array(upper)) / 2
        return self._bench.constant("q_mid", "middle of the joints' ranges", middle)
