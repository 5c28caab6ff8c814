"""One trial: start, phases, monitors, outcome. A pure function of (program, trial number, seed)."""

from __future__ import annotations

import hashlib
import json
import time
from importlib import metadata
from typing import Protocol

import numpy as np

from graspdsl.basis.spaces import TaskSpace
from graspdsl.compiler.graph import ControllerGraph, controllers_in
from graspdsl.compiler.pipeline import Pipeline, Tick
from graspdsl.compiler.program import CheckedPhase, Program
from graspdsl.objects.shapes import Body
from graspdsl.spec.program import Phase, Until
from graspdsl.trials.logbook import Logbook
from graspdsl.trials.monitors import Monitors
from graspdsl.trials.outcomes import Outcome, Verdict
from graspdsl.trials.record import Trial, TrialRecord
from graspdsl.trials.starts import draws, generator
from graspdsl.worlds.protocol import InfeasibleStartError, Observation, Start, Witness, World, WorldCrashError

MOST_REDRAWS = 500
AT_LIMIT = 1e-3  # rad or m


class WitnessedWorld(World, Witness, Protocol):
    """A world whose truth can be asked."""


def versions() -> dict[str, str]:
    """The versions of what a trial's numbers depend on."""
    return {name: metadata.version(name) for name in ("graspdsl", "numpy", "pybullet")}


def identity(program: Program, number: int, seed: int) -> str:
    """A hash of all that a trial's numbers depend on: the spec, the trial number, the seed and the versions."""
    spec = program.spec.model_dump(mode="json", exclude={"trials": {"count", "seed"}, "name": True, "about": True})
    whole = json.dumps([spec, number, seed, versions()], sort_keys=True)
    return hashlib.sha256(whole.encode()).hexdigest()[:16]


class TrialLoop:
    """Runs trials of one program on one world, one after the other."""

    def __init__(self, program: Program, world: WitnessedWorld, body: Body) -> None:
        self._program, self._world, self._body = program, world, body
        self._pipelines = program.pipelines()

    def run(self, number: int, seed: int) -> Trial:
        """Run one trial. What goes wrong in the world is its outcome, not an exception."""
        began = time.perf_counter()
        random = generator(seed, number)
        start, redraws, log = None, 0, Logbook(np.zeros(3))
        try:
            start, redraws, observation = self._begin(random)
            log = Logbook(self._world.truth().object_position)
            verdict = self._phases(observation, log)
        except WorldCrashError as error:
            verdict = Verdict(Outcome.CRASHED, str(error))
        except InfeasibleStartError as error:
            redraws, verdict = MOST_REDRAWS, Verdict(Outcome.CRASHED, str(error))
        finally:
            self._world.close()
        record = TrialRecord(
            number=number,
            identity=identity(self._program, number, seed),
            outcome=verdict.outcome,
            detail=verdict.detail,
            start=start.drawn if start else {},
            redraws=redraws,
            orientation_start=log.start.orientation,
            orientation_end=log.end.orientation,
            force_residual_start=log.start.force_residual,
            force_residual_end=log.end.force_residual,
            moment_residual_start=log.start.moment_residual,
            moment_residual_end=log.end.moment_residual,
            contact_forces=log.contact_forces,
            object_shift=log.shift,
            object_lean=log.lean,
            ticks=log.ticks,
            ticks_to_converge=log.ticks_to_converge if verdict.outcome is Outcome.CONVERGED else None,
            largest_leak=log.largest_leak,
            leaking_ticks=log.leaking_ticks,
            point_error=log.point_error(),
            normal_error=log.normal_error(),
            world_s=len(log.measures) / self._world.info.rate,
            wall_s=time.perf_counter() - began,
        )
        return Trial(record, log.trajectory())

    def _begin(self, random: np.random.Generator) -> tuple[Start, int, Observation]:
        surface = self._program.robot.hand.palm_surface
        starts = draws(self._program.spec.trials.start, self._body, surface, random)
        reason = ""
        for redraws, start in zip(range(MOST_REDRAWS), starts, strict=False):
            try:
                return start, redraws, self._world.reset(start, int(random.integers(2**31)))
            except InfeasibleStartError as error:
                reason = str(error)
        raise InfeasibleStartError(f"no start in {MOST_REDRAWS} draws was feasible, the last because {reason}")

    def _phases(self, observation: Observation, log: Logbook) -> Verdict:
        first = observation
        for index, phase in enumerate(self._program.phases):
            settings = self._program.spec.program[index]
            ticks_left = round(settings.limit * self._world.info.rate)
            for stage, pipeline in zip(phase.stages, self._pipelines[index], strict=True):
                until = settings.until if stage is phase.stages[-1] else _until_of(stage, settings.until)
                run = _Stage(self._program, self._world, phase, until, index, log)
                observation, ticks_left, verdict = run.run(pipeline, observation, ticks_left)
                if verdict is not None and verdict.outcome is Outcome.TIMEOUT:
                    return self._out_of_time(first, observation, phase, settings)
                if verdict is not None:
                    return verdict
        return Verdict(Outcome.CONVERGED)

    def _out_of_time(
        self, first: Observation, observation: Observation, phase: CheckedPhase, settings: Phase
    ) -> Verdict:
        """What kept a phase from its end: a contact that was never made, a joint at its limit, or just time."""
        missing = [self._world.info.contacts[c] for c in phase.grasp.contacts if not observation.touching[c]]
        if missing:
            return Verdict(Outcome.CONTACT_LOST, f"{', '.join(missing)} made no contact within {settings.limit:g} s")
        info = self._world.info
        at_limit = (observation.joints > info.upper - AT_LIMIT) | (observation.joints < info.lower + AT_LIMIT)
        stuck = at_limit & (np.abs(observation.joints - first.joints) > AT_LIMIT)
        joints = [name for name, is_stuck in zip(info.joints, stuck, strict=True) if is_stuck]
        if joints:
            return Verdict(Outcome.JOINT_LIMIT, f"{', '.join(joints)} at a limit")
        return Verdict(Outcome.TIMEOUT, f"not converged within {settings.limit:g} s")


class _Stage:
    """One controller of a phase, run until its end conditions have held, a monitor speaks or time is up."""

    def __init__(
        self, program: Program, world: WitnessedWorld, phase: CheckedPhase, until: Until, index: int, log: Logbook
    ) -> None:
        self._world, self._phase, self._until, self._index, self._log = world, phase, until, index, log
        self._monitors = Monitors(
            phase.grasp,
            world.info.contacts,
            program.robot.hand.palm,
            world.info.rate,
            program.spec.control.curvature_radius,
        )

    def run(
        self, pipeline: Pipeline, observation: Observation, ticks_left: int
    ) -> tuple[Observation, int, Verdict | None]:
        """The last observation, the ticks left of the phase's limit, and a verdict if the trial ends here."""
        held, hold = 0, round(self._until.hold * self._world.info.rate)
        closing = self._until.contact is not None
        while True:
            tick, truth = pipeline.evaluate(observation), self._world.truth()
            now = self._log.write(self._index, self._phase.grasp, observation, truth, tick)
            held = held + 1 if self._met(observation, tick) else 0
            self._log.held_since = len(self._log.measures) - held if held else None
            if held > hold:
                return observation, ticks_left, None
            verdict = self._monitors.watch(observation, truth, self._log.shift)
            if verdict is None and not closing:
                verdict = self._monitors.watch_contacts(observation) or self._monitors.watch_progress(now)
            if verdict is None and ticks_left == 0:
                verdict = Verdict(Outcome.TIMEOUT)
            if verdict is not None:
                return observation, ticks_left, verdict
            observation = self._world.step(tick.command)
            ticks_left -= 1

    def _met(self, observation: Observation, tick: Tick) -> bool:
        """Whether the end conditions hold, as the hand senses them."""
        until = self._until
        force, moment = np.linalg.norm(tick.force_residual), np.linalg.norm(tick.moment_residual)
        touching = bool(observation.touching[list(self._phase.grasp.contacts)].all())
        return (
            touching
            and (until.force_residual is None or bool(force < until.force_residual))
            and (until.moment_residual is None or bool(moment < until.moment_residual))
        )


def _until_of(stage: ControllerGraph, until: Until) -> Until:
    """The part of the end conditions that a stage before the last can meet: those on the residuals it lowers."""
    spaces = {node.potential.space for node in controllers_in(stage)}
    kept = {
        "force_residual": until.force_residual if TaskSpace.NET_FORCE in spaces else None,
        "moment_residual": until.moment_residual if TaskSpace.NET_MOMENT in spaces else None,
    }
    conditions = kept if any(kept.values()) else {"contact": "all"}
    return Until.model_validate({**conditions, "hold": until.hold})
