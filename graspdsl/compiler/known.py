"""What is known of a controller without running it: where ◁ takes nothing away, and which controllers move alike."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

from graspdsl.basis.effectors import EFFECTORS, Effector
from graspdsl.basis.potentials import POTENTIALS, Potential
from graspdsl.basis.resources import ContactSet
from graspdsl.compiler.graph import (
    Composition,
    ControllerGraph,
    ControllerNode,
    ControllerReference,
    SensorReference,
    VectorReference,
    compositions_in,
)
from graspdsl.spec.program import Control

RIGHT_ANGLES = (
    "all contacts are controlled, with equal weights, so that the two gradients are at right angles, "
    "Σ (P_i F)·(f_i × M) = F·(F × M) = 0, and the projector takes nothing away"
)
SAME_GAINS = "force and moment have the same gain, so that the sum −k (∇ε_fr + ∇ε_mr/r²) is −k ∇ε_w"


@dataclass(frozen=True, slots=True)
class Fact:
    """What holds of a controller whatever is sensed, to rounding: ``says`` it, with its formula, and ``why``."""

    says: str
    why: str

    def __str__(self) -> str:
        return f"{self.says}: {self.why}"


def facts_about(graph: ControllerGraph, control: Control) -> list[Fact]:
    """What is known of a controller, as it is carried out under control settings."""
    sums = [inner for inner in compositions_in(graph) if is_plain_sum(inner, control)]
    found = [Fact(f"◁ is a plain sum in {written(inner)}", RIGHT_ANGLES) for inner in sums]
    for inner in filter(sums.__contains__, _alone(graph)):
        other = written(replace(inner, terms=inner.terms[::-1]))
        found.append(Fact(f"{written(inner)} moves as {other}", "a sum does not depend on the order of its terms"))
        whole = _whole_of(inner, control)
        found += [Fact(f"{written(inner)} moves as {whole}", SAME_GAINS)] if whole else []
    return found


def is_plain_sum(graph: Composition, control: Control) -> bool:
    """Whether ◁ takes nothing away from the lower term: Σ (P_i F)·(f_i × M) = F·(F × M) = 0.

    Force and moment residual of the same contacts, all of which move, each with the same weight, projected along
    gradients in tangent frames (or turned without gravity, where both gradients are zero).
    """
    nodes = [term for term in graph.terms if isinstance(term, ControllerNode)]
    potentials = {node.potential.symbol: node.potential for node in nodes}
    normal = [{symbol, other} for symbol, known in potentials.items() for other in known.normal_to]
    if set(potentials) not in normal or len(nodes) != len(graph.terms) or len(nodes) != len(potentials):
        return False
    if control.nullspace != "gradient" or control.surface != "tangent":
        return False
    sets = [resources for node in nodes for resources in (node.effector_resources, node.sensor_resources)]
    return all(
        isinstance(resources, ContactSet)
        and not resources.has_gravity
        and len(set(filter(None, resources.weights.tolist()))) == 1
        and not (resources.has_virtual and control.virtual == "common")
        and resources.same_as(sets[0])
        for resources in sets
    )


def protection(control: Control) -> str:
    """What of a level the null space that lower ones run in protects."""
    if control.nullspace == "task":
        return "all that it senses, to first order, as far as its Jacobian τ is right (nullspace: task)"
    return "one direction of what it moves, that of its gradient, and not all that it senses (nullspace: gradient)"


def summed_plainly(graph: ControllerGraph, control: Control) -> set[ControllerNode]:
    """The controllers of a graph that a ◁ which is a plain sum joins."""
    sums = [inner for inner in compositions_in(graph) if is_plain_sum(inner, control)]
    return {term for inner in sums for term in inner.terms if isinstance(term, ControllerNode)}


def written(graph: ControllerGraph) -> str:
    """A graph as a formula without abbreviations."""
    if isinstance(graph, Composition):
        parts = [f"({written(t)})" if isinstance(t, Composition) else written(t) for t in graph.terms]
        return " ◁ ".join(parts)
    return graph.label + (f" ({reference_of(graph)})" if graph.reference else "")


def reference_of(node: ControllerNode) -> str:
    """The reference of a controller as the formula has it, without abbreviations; nothing where there is none."""
    match node.reference:
        case VectorReference(label) | SensorReference(label):
            return label
        case ControllerReference(controller):
            return written(controller)
    return ""


def _alone(graph: ControllerGraph) -> Iterator[Composition]:
    """The ◁ of a graph that are no term of another, to which more than its displacement would matter."""
    if isinstance(graph, Composition):
        yield graph
    for node in _terms(graph):
        if isinstance(node.reference, ControllerReference):
            yield from _alone(node.reference.controller)


def _terms(graph: ControllerGraph) -> list[ControllerNode]:
    if isinstance(graph, ControllerNode):
        return [graph]
    return [node for term in graph.terms for node in _terms(term)]


def _whole_of(graph: Composition, control: Control) -> str | None:
    """The one controller whose gradient is the sum of those of a plain sum, as a formula."""
    nodes = [term for term in graph.terms if isinstance(term, ControllerNode)]
    for effector in EFFECTORS.values():
        if parts_of(effector, control) and set(effector.parts) == {node.effector.symbol for node in nodes}:
            whole, moved, sensed = potential_of(effector.symbol), nodes[0].effector_resources, nodes[0].sensor_resources
            return f"{whole.symbol}|{effector.symbol}({moved.label}) {whole.sensors[0]}({sensed.label})"
    return None


def parts_of(effector: Effector, control: Control) -> Sequence[tuple[Potential, str]]:
    """The controllers, as potentials and effector transforms, whose displacements add up to that of the one with this
    effector transform; none where they do not, for their gains are others."""
    parts = [(potential_of(part), part) for part in effector.parts]
    same_gain = all(getattr(control, owner.law.gain) == 1.0 for owner, _ in parts if owner.law.gain)
    return parts if same_gain else []


def potential_of(effector: str) -> Potential:
    """The potential that an effector transform belongs to."""
    return next(known for known in POTENTIALS.values() if effector in known.effectors)
