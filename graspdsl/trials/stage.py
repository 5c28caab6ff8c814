"""One controller of a phase, run until its end conditions have held, a monitor speaks or time is up."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

from graspdsl.compiler.graph import ControllerGraph
from graspdsl.compiler.phase import CheckedPhase, conditions_lowered
from graspdsl.compiler.pipeline import Pipeline, Tick
from graspdsl.spec.program import Until
from graspdsl.trials.end_conditions import is_low, unmet
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
        waits_for_residual = not (self.until.force_residual is None and self.until.moment_residual is None)
        touched = self.until.contact is None
        held_from: float | None = None
        while True:
            tick, truth = pipeline.evaluate(observation), self.world.truth()
            now = self.log.write(self.index, self.phase.grasp, observation, truth, tick)
            if not self._met(self.until, observation, tick):
                held_from, self.log.held_since = None, None
            elif held_from is None:
                held_from, self.log.held_since = observation.time, len(self.log.measures) - 1
            touched = touched or bool(observation.touching[list(self.phase.grasp.contacts)].all())
            met = held_from is not None
            verdict = self.monitors.watch(observation, truth, self.log.shift, locked=tick.locked, met=met)
            if verdict is None and touched:
                verdict = self.monitors.watch_contacts(observation)
            if verdict is not None:
                return StageEnd(observation, verdict)
            if held_from is not None and observation.time - held_from >= self.until.hold - ROUNDING:
                return StageEnd(observation)
            for earlier, condition in enumerate(self.before):
                if not is_low(condition, tick):
                    return StageEnd(observation, back_to=earlier)
            stalled = waits_for_residual and self.monitors.has_stalled(now)
            if stalled and held_from is None:  # a residual that is low enough need not fall
                why = f"the residual stopped falling: {self._waited_for(observation, tick, held_from)}"
                return StageEnd(observation, Verdict(Outcome.LOCAL_MINIMUM, why))
            if observation.time >= self.deadline - ROUNDING:
                why = self._waited_for(observation, tick, held_from)
                return StageEnd(observation, Verdict(Outcome.TIMEOUT, why))
            observation = self.world.step(tick.command)

    def _met(self, until: Until, observation: Observation, tick: Tick) -> bool:
        """Whether end conditions hold, as the hand senses them: every contact touches and what is bounded is low."""
        return bool(observation.touching[list(self.phase.grasp.contacts)].all()) and is_low(until, tick)

    def _waited_for(self, observation: Observation, tick: Tick, held_from: float | None) -> str:
        """What keeps the stage from its end: the end conditions that do not hold, or how long all of them have."""
        if held_from is not None:
            return f"the end conditions held for {observation.time - held_from:.1f} s of {self.until.hold:g} s"
        names = self.monitors.info.contacts
        away = [names[contact] for contact in self.phase.grasp.contacts if not observation.touching[contact]]
        return unmet(self.until, tick, away)


def until_of(stage: ControllerGraph, until: Until) -> Until:
    """The part of a phase's end conditions that a stage can meet: those on what its potentials lower."""
    kept = {name: getattr(until, name) for name in conditions_lowered(stage)}
    conditions = kept if any(kept.values()) else {"contact": "all"}
    return Until.model_validate({**conditions, "hold": until.hold})


def loosened(until: Until, factor: float) -> Until:
    """End conditions with bounds larger by a factor."""
    scaled = {
        name: None if bound is None else bound * factor
        for name, bound in (("force_residual", until.force_residual), ("moment_residual", until.moment_residual))
    }
    return until.model_copy(update=scaled)
