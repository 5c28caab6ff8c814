"""What makes a spec one of the chapter's experiments (Sec. 4.5): a name alone does not."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

from graspdsl.compiler.graph import controllers_in
from graspdsl.compiler.phase import CheckedPhase
from graspdsl.compiler.program import Program
from graspdsl.diagnostics import listed

Resources = frozenset[frozenset[str]]

HAND = "barrett"
THUMB, FIRST, SECOND = "finger-3", "finger-1", "finger-2"
THUMB_AND_VIRTUAL: Resources = frozenset({frozenset({THUMB}), frozenset({FIRST, SECOND})})
THREE_FINGERS: Resources = frozenset(frozenset({finger}) for finger in (THUMB, FIRST, SECOND))
CLOSE = ("φ_f|τ_f σ_f",)
SLIDE_TO_GRASP = ("φ_p|τ_p σ_p", "φ_mr|τ_mrx σ_mr", "φ_fr|τ_frx σ_fr", "φ_f|τ_f σ_f")  # Eq. 4.24 with 4.30
PROGRAM = (CLOSE, SLIDE_TO_GRASP)


@dataclass(frozen=True, slots=True)
class Setup:
    """An experiment: the object, the side it is approached from, and the fingers of each resource of the grasp."""

    object: str
    approach: str
    resources: Resources


SETUPS: Mapping[str, Setup] = {
    "experiment-1": Setup("towel-roll", "side", THUMB_AND_VIRTUAL),
    "experiment-2": Setup("towel-roll", "top", THREE_FINGERS),
    "experiment-3": Setup("squirt-bottle", "side", THUMB_AND_VIRTUAL),
    "experiment-4": Setup("detergent-bottle", "side", THUMB_AND_VIRTUAL),
}


def departure(program: Program) -> str:
    """In what a program that bears an experiment's name is not that experiment; empty where it is, or bears no such
    name.

    Mount, friction, sensing, gains, bounds, numbers of the start, seed and count of trials may differ.
    """
    setup = SETUPS.get(program.spec.name)
    return "" if setup is None else next(_departures(program, setup), "")


def _departures(program: Program, setup: Setup) -> Iterator[str]:
    scene, trials = program.spec.scene, program.spec.trials
    if not program.world.has("hand"):
        yield "its contacts float"
        return
    if scene.object != setup.object:
        found = scene.object if isinstance(scene.object, str) else "one of its own"
        yield f"its object is {found}, not {setup.object}"
    if scene.hand != HAND:
        yield f"its hand is {scene.hand}, not {HAND}"
    if scene.gravity == 0.0:
        yield "nothing in it has weight"
    if (approach := trials.start.approach or "side") != setup.approach:
        yield f"the hand comes from the {approach}, not from the {setup.approach}"
    if trials.grid is not None:
        yield "its starts lie on a grid"
    if program.probes:
        yield "its contacts move by probing, not by sliding"
    if len(program.phases) != len(PROGRAM):
        yield f"its program has {len(program.phases)} formulas, not {len(PROGRAM)}"
        return
    for phase, controllers in zip(program.phases, PROGRAM, strict=True):
        if _controllers(phase) != controllers:
            yield f"{phase.label} is not made of {listed(controllers)}"
        if (resources := _resources(phase, program)) != setup.resources:
            yield f"{phase.label} acts on {_said(resources)}, not on {_said(setup.resources)}"


def _controllers(phase: CheckedPhase) -> tuple[str, ...]:
    return tuple(
        f"{node.potential.symbol}|{node.effector.symbol} {node.sensor.symbol}"
        for stage in phase.stages
        for node in controllers_in(stage)
    )


def _resources(phase: CheckedPhase, program: Program) -> Resources:
    names = (*program.robot.contacts, "gravity")
    return frozenset(frozenset(names[contact] for contact, _ in member.weights) for member in phase.grasp.members)


def _said(resources: Resources) -> str:
    """Resources as a formula writes them."""
    members = [f"<{', '.join(sorted(names))}>" if len(names) > 1 else min(names) for names in resources]
    return f"{{{', '.join(sorted(members))}}}"
