"""Many floating trials at once: the same compiled pipelines over a batch of starts."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from graspdsl.arrays import Array, Flags
from graspdsl.compiler.pipeline import Pipeline
from graspdsl.objects.surfaces.surface import Surface
from graspdsl.worlds.floating import sensed, slid


@dataclass(frozen=True, slots=True)
class BatchResult:
    """What became of N starts. points: (N, k, 3) [m]; force_residual (N,) (1) and moment_residual (N,) [m] at the end;
    converged: (N,); ticks: (N,), the step from which on both residuals stayed low, or all steps.
    """

    points: Array
    force_residual: Array
    moment_residual: Array
    converged: Flags
    ticks: Array


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
    points = points.copy()
    count = len(points)
    held, stage = np.zeros(count, dtype=int), np.zeros(count, dtype=int)
    ticks = np.full(count, steps, dtype=float)
    force, moment = np.zeros(count), np.zeros(count)
    running = np.ones(count, dtype=bool)
    for step in range(steps + 1):
        for index, pipeline in enumerate(pipelines):
            chosen = np.flatnonzero(running & (stage == index))
            if len(chosen) == 0:
                continue
            values = pipeline.values(sensed(surface, points[chosen], 0.0, 0.0))
            force[chosen] = np.linalg.norm(values[pipeline.force_residual], axis=-1)
            moment[chosen] = np.linalg.norm(values[pipeline.moment_residual], axis=-1)
            last = index == len(pipelines) - 1
            low = (force[chosen] < force_bound) & ((moment[chosen] < moment_bound) | (not last))
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
            if step < steps and len(moving):
                rows = np.isin(chosen, moving)
                points[moving] = slid(surface, points[moving], values[pipeline.command][rows])
        if not running.any():
            break
    converged = held >= hold
    return BatchResult(points, force, moment, converged, np.where(converged, ticks, steps))
