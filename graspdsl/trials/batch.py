"""Many floating trials at once: the same compiled pipelines over a batch of starts."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from graspdsl.arrays import Array, Flags
from graspdsl.compiler.pipeline import Pipeline
from graspdsl.objects.surfaces.surface import Surface
from graspdsl.trials.stalling import StallWatch
from graspdsl.worlds.floating import sensed, slid


@dataclass(frozen=True, slots=True)
class BatchResult:
    """What became of N starts. points: (N, k, 3) [m]; force_residual (N,) (1) and moment_residual (N,) [m] at the end;
    converged: (N,); ticks: (N,), the step from which on both residuals stayed low, or all steps. stalled: (N,), those
    given up because their residual had stopped falling, where a watch was asked for.
    """

    points: Array
    force_residual: Array
    moment_residual: Array
    converged: Flags
    ticks: Array
    stalled: Flags


@dataclass(frozen=True, slots=True)
class BatchStage:
    """A stage of a batch: its pipeline and the bounds that the residuals must stay below, ‖ρ_f‖ (1) and ‖ρ_m‖ [m]."""

    pipeline: Pipeline
    force_bound: float
    moment_bound: float


def run_batch(
    pipelines: tuple[Pipeline, ...],
    surface: Surface,
    points: Array,
    *,
    force_bound: float,
    moment_bound: float,
    hold: int = 20,
    steps: int = 1000,
    stop: bool = True,
) -> BatchResult:
    """Run contacts from points (N, k, 3) [m] until both residuals have stayed below their bounds for ``hold`` steps.

    Several pipelines are the stages of ``a then b``: a start goes from one to the next once the residual of the stage
    has stayed low as long, the force's for all but the last. Contacts that have converged stay where they are, or with
    ``stop=False`` go on, and have converged if both residuals were low over the last ``hold`` of all steps.
    """
    last = len(pipelines) - 1
    stages = [
        BatchStage(pipeline, force_bound, moment_bound if index == last else np.inf)
        for index, pipeline in enumerate(pipelines)
    ]
    return run_stages(stages, surface, points, hold=hold, steps=steps, stop=stop)


def run_stages(
    stages: Sequence[BatchStage],
    surface: Surface,
    points: Array,
    *,
    hold: int,
    steps: int,
    stop: bool = True,
    weight: float = 0.0,
    stalling: StallWatch | None = None,
) -> BatchResult:
    """As :func:`run_batch`, each stage to bounds of its own, on an object of this weight [N].

    Contacts that ``stalling`` finds in a local minimum stay where they are.
    """
    points = points.copy()
    count = len(points)
    held, stage = np.zeros(count, dtype=int), np.zeros(count, dtype=int)
    ticks = np.full(count, steps, dtype=float)
    force, moment = np.zeros(count), np.zeros(count)
    running, stalled = np.ones(count, dtype=bool), np.zeros(count, dtype=bool)
    for step in range(steps + 1):
        for index, at in enumerate(stages):
            chosen = np.flatnonzero(running & (stage == index))
            if len(chosen) == 0:
                continue
            pipeline = at.pipeline
            values = pipeline.values(sensed(surface, points[chosen], 0.0, weight))
            force[chosen] = np.linalg.norm(values[pipeline.force_residual], axis=-1)
            moment[chosen] = np.linalg.norm(values[pipeline.moment_residual], axis=-1)
            last = index == len(stages) - 1
            low = (force[chosen] < at.force_bound) & (moment[chosen] < at.moment_bound)
            held[chosen] = np.where(low, held[chosen] + 1, 0)
            done = chosen[held[chosen] >= hold]
            if last:
                ticks[chosen] = np.where(held[chosen] == hold, step - hold + 1, ticks[chosen])
                done = done if stop else done[:0]
                running[done] = False
            else:
                stage[done] += 1
                held[done] = 0
            moving = np.setdiff1d(chosen, done, assume_unique=True)
            if stalling is not None:
                stalling.begin_anew(done)
                stuck = stalling.watch(step, moving, force[moving], moment[moving])
                given_up = moving[stuck & (held[moving] == 0)]  # a residual that is low enough need not fall
                stalled[given_up], running[given_up] = True, False
                moving = np.setdiff1d(moving, given_up, assume_unique=True)
            if step < steps and len(moving):
                rows = np.isin(chosen, moving)
                points[moving] = slid(surface, points[moving], values[pipeline.command][rows])
        if not running.any():
            break
    converged = held >= hold
    return BatchResult(points, force, moment, converged, np.where(converged, ticks, steps), stalled)
