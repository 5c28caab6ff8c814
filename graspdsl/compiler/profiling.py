"""How long a pipeline takes, step by step and as a whole."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from statistics import median

from graspdsl.compiler.pipeline import Pipeline
from graspdsl.worlds.protocol import Observation

TIMES = 200


@dataclass(frozen=True, slots=True)
class Profile:
    """Medians [µs] of how long each step takes as numpy calls it, nothing for what is read, and a whole tick as its
    backend makes it; ``first`` [s]: how long the first of these took, with what is compiled at it."""

    steps: tuple[float, ...]
    tick: float
    first: float


def profiled(pipeline: Pipeline, observation: Observation) -> Profile:
    """How long a pipeline takes for an observation, certificate and all, one that locks no joint."""
    values = pipeline.values(observation)
    steps = []
    for step in pipeline.steps:
        inputs = [values[place] for place in step.inputs]
        steps.append(0.0 if step.reading is not None else _microseconds(partial(step.function, *inputs)))
    began = time.perf_counter()
    pipeline.ticks(observation)
    first = time.perf_counter() - began
    return Profile(tuple(steps), _microseconds(lambda: pipeline.ticks(observation)), first)


def _microseconds(call: Callable[[], object]) -> float:
    times = []
    for _ in range(TIMES):
        began = time.perf_counter()
        call()
        times.append(time.perf_counter() - began)
    return 1e6 * median(times)
