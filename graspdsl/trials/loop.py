"""One trial: start, phases, monitors, outcome. A pure function of (program, trial number, seed)."""

from __future__ import annotations

import hashlib
import json
import time
from importlib import metadata

import numpy as np

from graspdsl.compiler.program import CheckedPhase, Program
from graspdsl.objects.shapes import Body
from graspdsl.spec.program import Phase
from graspdsl.trials.evaluation import Evaluation
from graspdsl.trials.logbook import Logbook
from graspdsl.trials.monitors import Monitors
from graspdsl.trials.outcomes import Outcome, Verdict
from graspdsl.trials.record import Trial, TrialRecord
from graspdsl.trials.stage import Stage, StageEnd, WitnessedWorld, loosened, until_of
from graspdsl.trials.starts import draws, generator
from graspdsl.worlds.protocol import InfeasibleStartError, Observation, Start, WorldCrashError

MOST_REDRAWS = 500
AT_LIMIT = 1e-3  # rad or m
SECONDS_STALLED = 6.0  # without progress of a residual, sliding or floating
PROBES_STALLED = 15


def versions() -> dict[str, str]:
    """The versions of what a trial's numbers depend on."""
    return {name: metadata.version(name) for name in ("graspdsl", "numpy", "pybullet", "scipy")}


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
        self._evaluation = Evaluation(program.spec.evaluate, program.spec.scene.friction)

    def run(self, number: int, seed: int) -> Trial:
        """Run one trial. What goes wrong in the world is its outcome, not an exception."""
        began = time.perf_counter()
        random = generator(seed, number)
        start, redraws, log = None, 0, Logbook(np.zeros(3))
        quality = self._evaluation.of_nothing()
        try:
            start, redraws, observation = self._begin(random)
            levels = max(len(pipeline.leaks) for stages in self._pipelines for pipeline in stages)
            log = Logbook(self._world.truth().object_position, levels)
            verdict = self._phases(observation, log)
            quality = self._evaluation.of(self._world, self._program.phases[-1].grasp.contacts)
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
            samples=log.samples,
            world_s=log.world_s,
            wall_s=time.perf_counter() - began,
            quality=quality,
        )
        return Trial(record, log.trajectory())

    def _begin(self, random: np.random.Generator) -> tuple[Start, int, Observation]:
        surface = self._program.robot.hand.palm_surface
        floats = self._program.world.floats
        starts = draws(self._program.spec.trials.start, self._body, surface, random, floats=floats)
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
            end = self._phase(index, observation, log)
            if end.verdict is not None and end.verdict.outcome is Outcome.TIMEOUT:
                return self._out_of_time(first, end.observation, phase, settings)
            if end.verdict is not None:
                return end.verdict
            observation = end.observation
        return self._monitors(self._program.phases[-1]).judge(log.shift)

    def _phase(self, index: int, observation: Observation, log: Logbook) -> StageEnd:
        """The stages of a phase, one to its end and then the next; with hysteresis, back again where one is undone."""
        phase, settings = self._program.phases[index], self._program.spec.program[index]
        conditions = [until_of(stage, settings.until) for stage in phase.stages[:-1]]
        kept = [loosened(condition, settings.hysteresis) for condition in conditions] if settings.hysteresis else []
        deadline, stage = observation.time + settings.limit, 0
        while True:
            until = settings.until if stage == len(conditions) else conditions[stage]
            monitors = self._monitors(phase)
            run = Stage(self._world, phase, index, until, deadline, monitors, log, kept[:stage])
            end = run.run(self._pipelines[index][stage], observation)
            if end.verdict is not None or (end.back_to is None and stage == len(conditions)):
                return end
            stage = stage + 1 if end.back_to is None else end.back_to
            observation = end.observation

    def _monitors(self, phase: CheckedPhase) -> Monitors:
        program = self._program
        return Monitors(
            phase.grasp,
            self._world.info.contacts,
            program.robot.hand.palm,
            program.spec.control.curvature_radius,
            samples=PROBES_STALLED if program.probes else round(SECONDS_STALLED * self._world.info.rate),
            held=program.spec.scene.held,
        )

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
