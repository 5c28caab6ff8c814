"""The stages of a program: controllers one after the other, each with what ends it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from graspdsl.basis.resources import ContactSet
from graspdsl.compiler.graph import ControllerGraph
from graspdsl.compiler.phase import conditions_lowered
from graspdsl.compiler.pipeline import Pipeline
from graspdsl.compiler.program import Program
from graspdsl.spec.program import Until


@dataclass(frozen=True, slots=True)
class Stage:
    """A controller of a phase that is run until its end conditions have held; ``number`` counts over all phases.

    ``kept``: the conditions of stages before it in its phase that must not be given up again, by the numbers of those
    stages; ``goes_back``: whether one of them is begun anew if they are. ``full_time``: whether it goes on to the limit
    though its conditions hold. ``name``: what messages call it; nothing where its phase has no other. ``contacts``: of
    the grasp, by number.
    """

    number: int
    phase: int
    grasp: ContactSet
    pipeline: Pipeline
    until: Until
    limit: float
    kept: Mapping[int, Until]
    goes_back: bool
    full_time: bool
    name: str
    contacts: Sequence[int]

    @property
    def awaits_residual(self) -> bool:
        """Whether a residual is bounded."""
        return not (self.until.force_residual is None and self.until.moment_residual is None)


def stages_of(program: Program) -> list[Stage]:
    """The stages of a program's phases, one after the other."""
    stages: list[Stage] = []
    phases = zip(program.phases, program.spec.program, program.pipelines(), strict=True)
    for index, (phase, settings, pipelines) in enumerate(phases):
        first = len(stages)
        conditions = [*(until_of(graph, settings.until) for graph in phase.stages[:-1]), settings.until]
        for place, (pipeline, until) in enumerate(zip(pipelines, conditions, strict=True)):
            before = enumerate(conditions[:place])
            kept = {first + earlier: loosened(condition, settings.hysteresis or 1.0) for earlier, condition in before}
            stage = Stage(
                number=first + place,
                phase=index,
                grasp=phase.grasp,
                pipeline=pipeline,
                until=until,
                limit=settings.limit,
                kept=kept,
                goes_back=settings.hysteresis is not None,
                full_time=settings.full_time and place == len(pipelines) - 1,
                name=f"stage {place + 1} of {len(pipelines)}" if len(pipelines) > 1 else "",
                contacts=list(phase.grasp.contacts),
            )
            stages.append(stage)
    return stages


def until_of(graph: ControllerGraph, until: Until) -> Until:
    """The part of a phase's end conditions that a stage can meet: those on what its potentials lower."""
    kept = {name: getattr(until, name) for name in conditions_lowered(graph)}
    conditions = kept if any(kept.values()) else {"contact": "all"}
    return Until.model_validate({**conditions, "hold": until.hold})


def loosened(until: Until, factor: float) -> Until:
    """End conditions with bounds larger by a factor."""
    scaled = {
        name: None if bound is None else bound * factor
        for name, bound in (("force_residual", until.force_residual), ("moment_residual", until.moment_residual))
    }
    return until.model_copy(update=scaled)
