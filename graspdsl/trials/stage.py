"""One controller of a phase, run until its end conditions have held, a monitor speaks or time is up."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from graspdsl.basis.spaces import TaskSpace
from graspdsl.compiler.graph import ControllerGraph, controllers_in
from graspdsl.compiler.pipeline import Pipeline, Tick
from graspdsl.compiler.program import CheckedPhase
from graspdsl.spec.program import Until
from graspdsl.trials.logbook import Logbook
from graspdsl.trials.monitors import Monitors
from graspdsl.trials.outcomes import Outcome, Verdict
from graspdsl.worlds.protocol import Observation, Witness, World

ROUNDING = 1e-9  # s


class WitnessedWorld(World, Witness, Protocol):
    """A world whose truth can be asked."""


@dataclass(frozen=True, slots=True)
class StageEnd:
    """How a stage ended: its last observation, a verdict if the trial ends with it, or the stage to go back to."""

    observation: Observation
    verdict: Verdict | None = None
    back_to: int | None = None


@dataclass(slots=True)
class Stage:
    """A stage about to run. ``before``: the conditions that earlier stages met and that must not be given up again."""

    world: WitnessedWorld
    phase: CheckedPhase
    index: int
    until: Until
    deadline: float
    monitors: Monitors
    log: Logbook
    before: Sequence[Until] = ()

    def run(self, pipeline: Pipeline, observation: Observation) -> StageEnd:
        """Run to the end of the stage."""
        closing = self.until.contact is not None
        held_from: float | None = None
        while True:
            tick, truth = pipeline.evaluate(observation), self.world.truth()
            now = self.log.write(self.index, self.phase.grasp, observation, truth, tick)
            if not self._met(self.until, observation, tick):
                held_from, self.log.held_since = None, None
            elif held_from is None:
                held_from, self.log.held_since = observation.time, len(self.log.measures) - 1
            if held_from is not None and observation.time - held_from >= self.until.hold - ROUNDING:
                return StageEnd(observation)
            for earlier, condition in enumerate(self.before):
                if not self._met(condition, observation, tick):
                    return StageEnd(observation, back_to=earlier)
            verdict = self.monitors.watch(observation, truth, self.log.shift)
            if verdict is None and not closing:
                verdict = self.monitors.watch_contacts(observation) or self.monitors.watch_progress(now)
            if verdict is None and observation.time >= self.deadline - ROUNDING:
                verdict = Verdict(Outcome.TIMEOUT)
            if verdict is not None:
                return StageEnd(observation, verdict)
            observation = self.world.step(tick.command)

    def _met(self, until: Until, observation: Observation, tick: Tick) -> bool:
        """Whether end conditions hold, as the hand senses them."""
        force, moment = np.linalg.norm(tick.force_residual), np.linalg.norm(tick.moment_residual)
        touching = bool(observation.touching[list(self.phase.grasp.contacts)].all())
        return (
            touching
            and (until.force_residual is None or bool(force < until.force_residual))
            and (until.moment_residual is None or bool(moment < until.moment_residual))
            and (until.force_error is None or bool(tick.force_error < until.force_error))
        )


def until_of(stage: ControllerGraph, until: Until) -> Until:
    """The part of a phase's end conditions that a stage can meet: those on the residuals it lowers."""
    spaces = {node.potential.space for node in controllers_in(stage)}
    kept = {
        "force_residual": until.force_residual if TaskSpace.NET_FORCE in spaces else None,
        "moment_residual": until.moment_residual if TaskSpace.NET_MOMENT in spaces else None,
    }
    conditions = kept if any(kept.values()) else {"contact": "all"}
    return Until.model_validate({**conditions, "hold": until.hold})


def loosened(until: Until, factor: float) -> Until:
    """End conditions with bounds larger by a factor."""
    scaled = {
        name: None if bound is None else bound * factor
        for name, bound in (("force_residual", until.force_residual), ("moment_residual", until.moment_residual))
    }
    return until.model_copy(update=scaled)
