"""Which programs do the same from equal starts, and why, as far as that is known without running them."""

from __future__ import annotations

from collections.abc import Hashable

from graspdsl.basis.resources import ContactSet, JointSet
from graspdsl.compiler.graph import (
    Composition,
    ControllerGraph,
    ControllerNode,
    ControllerReference,
    SensorReference,
    VectorReference,
)
from graspdsl.compiler.known import Fact, facts_about, is_plain_sum, parts_of
from graspdsl.compiler.program import Program
from graspdsl.spec.program import Control

SAME_PROGRAM = "they run the same program"


def known_of(program: Program) -> list[Fact]:
    """What is known of the controllers of a program, each fact once."""
    target = program.target
    stages = (graph for phase in program.phases for graph in phase.executed(target))
    return list(dict.fromkeys(fact for graph in stages for fact in facts_about(graph, target.control)))


def same_by_law(one: Program, other: Program) -> str | None:
    """Why two programs do the same from equal starts, whatever they meet: to the last bit, or but for rounding.

    None where that is not known.
    """
    if _course(one, exact=True) == _course(other, exact=True):
        return SAME_PROGRAM
    if _course(one) != _course(other):
        return None
    return "; ".join(dict.fromkeys(fact.why for program in (one, other) for fact in known_of(program)))


def _course(program: Program, *, exact: bool = False) -> Hashable:
    """All that decides what a program does from a start; equal values where what it does is equal."""
    spec, target = program.spec, program.target
    moves = tuple(
        tuple(_motion(graph, target.control, exact=exact) for graph in phase.executed(target))
        for phase in program.phases
    )
    grasps = tuple(_key(phase.grasp) for phase in program.phases)
    settings = (phase.model_dump(exclude={"run"}) for phase in spec.program)
    return moves, grasps, repr((*settings, spec.control, program.monitors, spec.scene))


def _motion(graph: ControllerGraph, control: Control, *, exact: bool) -> Hashable:
    """Equal for controllers that displace alike; of a sum, what is added up."""
    if isinstance(graph, Composition):
        terms = tuple(_motion(term, control, exact=True) for term in graph.terms)
        return frozenset(terms) if is_plain_sum(graph, control) and not exact else terms
    parts = () if exact else parts_of(graph.effector, control)
    own = (graph.potential, graph.effector.symbol)
    added = [_controller(graph, owner.symbol, part, control, exact=exact) for owner, part in parts or (own,)]
    return frozenset(added) if parts else added[0]


def _controller(node: ControllerNode, potential: str, effector: str, control: Control, *, exact: bool) -> Hashable:
    reference: Hashable = None
    match node.reference:
        case VectorReference(_, values):
            reference = values
        case SensorReference(_, factor, sensor, resources):
            reference = (factor, sensor.symbol, _key(resources))
        case ControllerReference(controller):
            reference = _motion(controller, control, exact=exact)
    return potential, effector, _key(node.effector_resources), _key(node.sensor_resources), reference


def _key(resources: ContactSet | JointSet) -> Hashable:
    if isinstance(resources, JointSet):
        return resources.joints
    return tuple(member.weights for member in resources.members)
