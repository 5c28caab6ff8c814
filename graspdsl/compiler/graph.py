"""The controller graph: a formula whose every name is resolved and whose every space is known."""

from __future__ import annotations

from dataclasses import dataclass

from graspdsl.basis.effectors import Effector
from graspdsl.basis.potentials import Potential
from graspdsl.basis.resources import ContactSet, JointSet
from graspdsl.basis.sensors import Sensor
from graspdsl.basis.spaces import GradientSpace


@dataclass(frozen=True, slots=True)
class VectorReference:
    """A reference given as numbers: one row a resource, (m, 3) flattened.

    ``label``: the name of the parameter that they are, or the numbers.
    """

    label: str
    values: tuple[float, ...]


@dataclass(frozen=True, slots=True)
class SensorReference:
    """A reference made of a sensor: factor · σ(Γ), as κ_f σ_n(Γ). ``parameter``: the name of a factor that has one."""

    label: str
    factor: float
    sensor: Sensor
    resources: ContactSet | JointSet
    parameter: str = ""


@dataclass(frozen=True, slots=True)
class ControllerReference:
    """A reference that a controller moves: what is sensed, displaced by one step of that controller (Eq. 4.31)."""

    controller: ControllerGraph


Reference = VectorReference | SensorReference | ControllerReference


@dataclass(frozen=True, slots=True)
class ControllerNode:
    """φ|τ(Γτ) σ(Γσ) (reference), resolved."""

    label: str
    potential: Potential
    effector: Effector
    effector_resources: ContactSet | JointSet
    sensor: Sensor
    sensor_resources: ContactSet | JointSet
    reference: Reference | None

    @property
    def gradient_space(self) -> GradientSpace:
        """What the controller displaces."""
        return self.effector.gradient_space


@dataclass(frozen=True, slots=True)
class Composition:
    """a ◁ b ◁ …: the last term has the highest priority (Eq. 4.19)."""

    terms: tuple[ControllerGraph, ...]

    @property
    def gradient_space(self) -> GradientSpace:
        """What the terms displace, all the same."""
        return self.terms[0].gradient_space


ControllerGraph = ControllerNode | Composition


def controllers_in(graph: ControllerGraph) -> list[ControllerNode]:
    """Every single controller of a graph, those of references too, in the order of the formula."""
    if isinstance(graph, Composition):
        return [node for term in graph.terms for node in controllers_in(term)]
    inner = controllers_in(graph.reference.controller) if isinstance(graph.reference, ControllerReference) else []
    return [graph, *inner]


def compositions_in(graph: ControllerGraph) -> list[Composition]:
    """Every ◁ of a graph, those of terms and of references too."""
    if isinstance(graph, Composition):
        return [graph, *(inner for term in graph.terms for inner in compositions_in(term))]
    reference = graph.reference
    return compositions_in(reference.controller) if isinstance(reference, ControllerReference) else []
