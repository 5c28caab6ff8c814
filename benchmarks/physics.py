"""What a trial of the main spec costs beside the engine's own steps, and what the controller costs of it.

The engine's step and the controller's tick are timed where they are called, in the trials themselves.
"""

from __future__ import annotations

import importlib
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
from measuring import Row, told

from graspdsl.compiler.pipeline import Pipeline
from graspdsl.compiler.program import program_of
from graspdsl.trials.setup import trial_loop

SPEC = Path(__file__).resolve().parents[1] / "specs" / "towel_roll_two_contacts.yaml"
SEED = 2006
BOUNDS = {"mujoco": "≤ 1.5", "bullet": "≤ 1.25"}
STEPS = {"mujoco": ("mujoco", "mj_step"), "bullet": ("pybullet", "stepSimulation")}
ROUNDS = {"mujoco": (3, 8), "bullet": (3, 2)}  # and how many trials each has
MANY = 128  # trials of one round in MuJoCo, of which others begin as some end


@dataclass
class Watched:
    """How often a function was called, and how long that took [s]."""

    calls: int = 0
    seconds: float = 0.0


@dataclass(frozen=True)
class Cost:
    """What trials took [s]: whole, the engine's steps, and the controller's ticks, of which there were so many."""

    whole: float
    physics: float
    control: float
    steps: int
    ticks: int
    trials: int


def rows() -> Iterator[Row]:
    """Trials in both engines."""
    costs: dict[str, list[Cost]] = {name: [] for name in STEPS if find_spec(STEPS[name][0])}
    for number in range(max(rounds for rounds, _ in ROUNDS.values())):
        for name, noted in costs.items():
            rounds, trials = ROUNDS[name]
            if number < rounds:
                noted.append(cost(name, range(number * trials, (number + 1) * trials)))
    for name, bound in BOUNDS.items():
        what = f"trials of the main spec in {name} / their {STEPS[name][1]} alone"
        if name not in costs:
            yield Row(what, bound=bound, note=f"{STEPS[name][0]} is not installed")
            continue
        found = costs[name]
        yield row(what, [one.whole / one.physics for one in found], bound, said(found))
        what = f"the controller / {STEPS[name][1]} in trials of the main spec in {name}"
        yield row(what, [one.control / one.physics for one in found])
    if "mujoco" in costs:
        found = [cost("mujoco", range(MANY))]
        what = f"{MANY} trials of the main spec in mujoco / their mj_step alone"
        yield row(what, [one.whole / one.physics for one in found], BOUNDS["mujoco"], said(found))
    if len(costs) == len(STEPS):
        both = list(zip(costs["bullet"], costs["mujoco"], strict=True))
        steps = [(one.physics / one.steps) / (other.physics / other.steps) for one, other in both]
        yield row("a step of bullet / a step of mujoco", steps)


def cost(name: str, numbers: range) -> Cost:
    """What trials in a world take, side by side as that runs them."""
    loop = trial_loop(program_of(SPEC.read_text("utf-8"), SPEC.name, (f"scene.world={name}",)))
    engine = importlib.import_module(STEPS[name][0])
    with watched(engine, STEPS[name][1]) as steps, watched(Pipeline, "ticks") as ticks:
        began = time.perf_counter()
        for _ in loop.run_all(numbers, SEED):
            pass
        whole = time.perf_counter() - began
    return Cost(whole, steps.seconds, ticks.seconds, steps.calls, ticks.calls, len(numbers))


@contextmanager
def watched(owner: Any, name: str) -> Iterator[Watched]:
    """The calls of a function from now on to the end."""
    function: Callable[..., Any] = getattr(owner, name)
    noted = Watched()

    def timed(*arguments: Any, **options: Any) -> Any:
        began = time.perf_counter()
        answer = function(*arguments, **options)
        noted.seconds += time.perf_counter() - began
        noted.calls += 1
        return answer

    setattr(owner, name, timed)
    try:
        yield noted
    finally:
        setattr(owner, name, function)


def said(costs: list[Cost]) -> str:
    """The medians, in words."""
    step = float(np.median([one.physics / one.steps for one in costs]))
    tick = float(np.median([one.control / one.ticks for one in costs]))
    trial = float(np.median([one.whole / one.trials for one in costs]))
    return f"step {told(step)}, controller {told(tick)} a call, trial {told(trial)}"


def row(what: str, ratios: npt.ArrayLike, bound: str = "", note: str = "") -> Row:
    """A row of ratios that are there already."""
    low, middle, high = (float(share) for share in np.quantile(np.asarray(ratios, float), [0.25, 0.5, 0.75]))
    return Row(what, middle, bound, (low, high), note)
