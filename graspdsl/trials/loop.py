"""One trial: start, phases, monitors, outcome. A pure function of (program, trial number, seed)."""

from __future__ import annotations

import time
from collections import Counter
from collections.abc import Callable, Sequence

import numpy as np

from graspdsl.compiler.phase import CheckedPhase
from graspdsl.compiler.program import Program
from graspdsl.quality.grade import CRASHED, NO_CONTACTS
from graspdsl.trials.evaluation import Evaluation
from graspdsl.trials.identity import identity
from graspdsl.trials.logbook import Logbook
from graspdsl.trials.monitors import Monitors, window_of
from graspdsl.trials.outcomes import Outcome, Verdict
from graspdsl.trials.record import RejectedStart, Trial, TrialRecord
from graspdsl.trials.stage import Stage, StageEnd, WitnessedWorld, loosened, until_of
from graspdsl.trials.starts import draws, generator
from graspdsl.worlds.protocol import (
    InfeasibleStartError,
    Observation,
    Start,
    UnreachableStartError,
    UnstableObjectError,
    WorldCrashError,
)

MOST_DRAWS = 500
TOLD_EACH = 25  # draws
OUT_OF_REACH_EACH, MOST_OUT_OF_REACH = 5, 50  # draws that the arm cannot reach, of an orientation and in all


OnDrawing = Callable[[int], None]


class NoFeasibleStartError(Exception):
    """The world could take up none of a trial's starts."""

    def __init__(self, rejected: Sequence[RejectedStart]) -> None:
        draws = len(rejected)
        [(reason, count)] = Counter(start.reason for start in rejected).most_common(1)
        share = "" if count == draws else f" ({count} times)"
        none = "the start is not feasible" if draws == 1 else f"no start in {draws} draws was feasible"
        super().__init__(f"{none}: {reason}{share}")


class TrialLoop:
    """Runs trials of one program on one world, one after the other; a trial has so many draws to find a start."""

    def __init__(self, program: Program, world: WitnessedWorld, most_draws: int = MOST_DRAWS) -> None:
        self._program, self._world = program, world
        self._most_draws = most_draws
        self._pipelines = program.pipelines()
        self._evaluation = Evaluation(program.spec.evaluate, program.spec.scene.friction, program.robot)

    def run(self, number: int, seed: int, on_drawing: OnDrawing | None = None) -> Trial:
        """Run one trial. What goes wrong in the world is its outcome, not an exception.

        on_drawing: is told now and then how many draws of a start could not be taken up so far.
        """
        began = time.perf_counter()
        random = generator(seed, number)
        start, rejected, log = None, list[RejectedStart](), Logbook(np.zeros(3))
        try:
            start, observation = self._begin(number, random, rejected, on_drawing)
            levels = max(len(pipeline.leaks) for stages in self._pipelines for pipeline in stages)
            log = Logbook(self._world.truth().object_position, levels)
            verdict = self._phases(observation, log)
            quality = self._evaluation.of(self._world, self._program.phases[-1].grasp.contacts)
        except WorldCrashError as error:
            verdict, quality = Verdict(Outcome.CRASHED, str(error)), self._evaluation.of_nothing(CRASHED)
        except NoFeasibleStartError as error:
            verdict = Verdict(Outcome.INFEASIBLE_START, str(error))
            quality = self._evaluation.of_nothing(NO_CONTACTS)
        except UnstableObjectError as error:
            verdict, quality = Verdict(Outcome.TOPPLED, str(error)), self._evaluation.of_nothing(NO_CONTACTS)
        finally:
            self._world.close()
        record = TrialRecord(
            number=number,
            identity=identity(self._program, number, seed),
            outcome=verdict.outcome,
            detail=verdict.detail,
            start=start.drawn if start else {},
            rejected=tuple(rejected),
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
            tare_s=self._world.info.tare_s,
            quality=quality,
        )
        return Trial(record, log.trajectory())

    def _begin(
        self,
        number: int,
        random: np.random.Generator,
        rejected: list[RejectedStart],
        on_drawing: OnDrawing | None,
    ) -> tuple[Start, Observation]:
        """The first start that the world takes up; those before it are added to ``rejected``."""
        surface = self._program.robot.hand.palm_surface
        floats = not self._program.world.has("hand")
        wanted = self._program.spec.trials.start_of(number)
        starts = draws(wanted, self._program.body, surface, random, floats=floats)
        most = 1 if wanted.is_fixed else self._most_draws
        start, beyond = next(starts), 0
        while len(rejected) < most and not beyond == len(rejected) == MOST_OUT_OF_REACH:
            try:
                return start, self._world.reset(start, int(random.integers(2**31)))
            except InfeasibleStartError as error:
                rejected.append(RejectedStart(start.drawn, str(error)))
                if on_drawing is not None and len(rejected) % TOLD_EACH == 0:
                    on_drawing(len(rejected))
                beyond += isinstance(error, UnreachableStartError)
                start = starts.send(isinstance(error, UnreachableStartError) and beyond % OUT_OF_REACH_EACH == 0)
        raise NoFeasibleStartError(rejected)

    def _phases(self, observation: Observation, log: Logbook) -> Verdict:
        first = observation
        for index, phase in enumerate(self._program.phases):
            settings = self._program.spec.program[index]
            end = self._phase(index, first, observation, log)
            if end.verdict is not None and end.verdict.outcome is Outcome.TIMEOUT:
                return self._monitors(phase, first).out_of_time(end.observation, settings.limit, end.verdict.detail)
            if end.verdict is not None:
                return end.verdict
            observation = end.observation
        return self._monitors(self._program.phases[-1], first).judge(log.shift)

    def _phase(self, index: int, first: Observation, observation: Observation, log: Logbook) -> StageEnd:
        """The stages of a phase, one to its end and then the next; with hysteresis, back again where one is undone."""
        phase, settings = self._program.phases[index], self._program.spec.program[index]
        conditions = [until_of(stage, settings.until) for stage in phase.stages[:-1]]
        kept = [loosened(condition, settings.hysteresis) for condition in conditions] if settings.hysteresis else []
        deadline, stage = observation.time + settings.limit, 0
        while True:
            until = settings.until if stage == len(conditions) else conditions[stage]
            monitors = self._monitors(phase, first)
            run = Stage(self._world, phase, index, until, deadline, monitors, log, kept[:stage])
            end = run.run(self._pipelines[index][stage], observation)
            if end.verdict is not None or (end.back_to is None and stage == len(conditions)):
                return end
            stage = stage + 1 if end.back_to is None else end.back_to
            observation = end.observation

    def _monitors(self, phase: CheckedPhase, first: Observation) -> Monitors:
        program, info = self._program, self._world.info
        return Monitors(
            program.monitors,
            phase.grasp,
            info,
            program.robot.hand.palm,
            program.spec.control.curvature_radius,
            window_of(program.monitors, info, probes=program.probes),
            first.joints,
        )
