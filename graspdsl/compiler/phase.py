"""A checked phase, and the one way from it to what runs: its controllers as a world carries them out, and pipelines."""

from __future__ import annotations

from dataclasses import dataclass

from graspdsl.basis.effectors import EFFECTORS
from graspdsl.basis.potentials import displaced_in
from graspdsl.basis.prelude import Definition
from graspdsl.basis.resources import ContactResource, ContactSet
from graspdsl.basis.sensors import SENSORS
from graspdsl.basis.spaces import GradientSpace
from graspdsl.compiler.graph import ControllerGraph, ControllerNode, ControllerReference, controllers_in
from graspdsl.compiler.lowering import compile_controller
from graspdsl.compiler.pipeline import Pipeline
from graspdsl.compiler.settings import Target
from graspdsl.hands.descriptions import Robot
from graspdsl.notation.printer import to_unicode
from graspdsl.notation.tree import Expression


@dataclass(frozen=True, slots=True)
class CheckedPhase:
    """A phase of a program: its controllers, run one after the other, and the resources its residuals are of.

    ``uses``: the definitions that its formula stands on, in the order in which they are met.
    """

    formula: Expression
    stages: tuple[ControllerGraph, ...]
    grasp: ContactSet
    uses: tuple[Definition, ...] = ()

    @property
    def label(self) -> str:
        """The formula in Unicode."""
        return to_unicode(self.formula)

    @property
    def holds(self) -> bool:
        """Whether it is of an object that is held: one that contacts turn, or whose weight is sensed."""
        nodes = [node for stage in self.stages for node in controllers_in(stage)]
        return any(
            node.gradient_space is GradientSpace.ROTATION
            or (isinstance(node.sensor_resources, ContactSet) and node.sensor_resources.has_gravity)
            for node in nodes
        )

    def executed(self, target: Target) -> tuple[ControllerGraph, ...]:
        """The controllers of its stages as they are carried out."""
        return tuple(executable(stage, target.probes) for stage in self.stages)

    def pipelines(self, target: Target) -> tuple[Pipeline, ...]:
        """The compiled stages: what trials run, maps run and ``explain`` shows."""
        return tuple(compile_controller(graph, self.grasp, target) for graph in self.executed(target))


def executable(graph: ControllerGraph, probes: bool = False) -> ControllerGraph:
    """A controller as a world carries it out.

    Rotations of contacts become references of φ_r, as Eq. 4.41 has it. Where contacts are displaced by probing, a
    controller that slides them is what moves its reference: a probe presses by touching (Sec. 4.1.2, 4.3.3).
    """
    sliding = [node.reference for node in controllers_in(graph) if probes and _slides(node)]
    if sliding and isinstance(sliding[0], ControllerReference):
        return sliding[0].controller
    if graph.gradient_space is not GradientSpace.ROTATION:
        return graph
    moved = next(n.effector_resources for n in controllers_in(graph) if n.gradient_space is GradientSpace.ROTATION)
    potential = displaced_in(GradientSpace.ROTATION)
    sensor, effector = SENSORS[potential.sensors[0]], EFFECTORS[potential.effectors[0]]
    label = f"{potential.symbol}|{effector.symbol}({moved.label}) {sensor.symbol}({moved.label})"
    return ControllerNode(label, potential, effector, moved, sensor, moved, ControllerReference(graph))


def conditions_lowered(graph: ControllerGraph) -> frozenset[str]:
    """The end conditions that a controller works towards, by their names in a spec."""
    return frozenset(name for node in controllers_in(graph) for name in node.potential.lowers)


def _slides(node: ControllerNode) -> bool:
    """Whether a controller moves contacts over a surface, as another one tells it to."""
    by_contacts = node.potential.displaced_by is GradientSpace.CARTESIAN
    return by_contacts and isinstance(node.reference, ControllerReference)


def grasp_of(stages: tuple[ControllerGraph, ...], robot: Robot) -> ContactSet:
    """The resources whose residuals matter: those of the first residual sensor, else those the phase moves, else all
    of the robot's contacts."""
    nodes = [node for stage in stages for node in controllers_in(stage)]
    graded = [node.sensor_resources for node in nodes if node.potential.is_residual]
    moved = [node.effector_resources for node in nodes]
    every = tuple(ContactResource(name, ((index, 1.0),)) for index, name in enumerate(robot.contacts))
    contacts = [found for found in [*graded, *moved] if isinstance(found, ContactSet)]
    return contacts[0] if contacts else ContactSet("all contacts", every, len(every))
