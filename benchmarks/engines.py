"""What a trial's physics costs in one engine and in the other: the same trials of the main spec, turn by turn.

Prints, for each engine, the processor's time of a step of physics, of a trial's physics and of a whole trial, then the
ratios. Physics is the engine's own step, which is timed where it is called; sensing, control and what is noted of
contacts are the rest.
"""

from __future__ import annotations

import importlib
import time
from pathlib import Path
from typing import Any

import numpy as np

from graspdsl.compiler.program import program_of
from graspdsl.trials.setup import trial_loop

SPEC = Path(__file__).resolve().parents[1] / "specs" / "towel_roll_two_contacts.yaml"
STEPS = {"bullet": ("pybullet", "stepSimulation"), "mujoco": ("mujoco", "mj_step")}
TRIALS, SEED = 4, 2006


def watched(module: str, name: str) -> list[float]:
    """The times [s] of all calls of a function from now on."""
    engine, times = importlib.import_module(module), list[float]()
    step = getattr(engine, name)

    def timed(*arguments: Any) -> None:
        began = time.process_time()
        step(*arguments)
        times.append(time.process_time() - began)

    setattr(engine, name, timed)
    return times


def main() -> None:
    """Measure all, and print the ratios."""
    text = SPEC.read_text("utf-8")
    times = [watched(*of) for of in STEPS.values()]
    loops = [trial_loop(program_of(text, SPEC.name, (f"scene.world={name}",))) for name in STEPS]
    steps, physics, whole = np.zeros((3, len(STEPS)))
    for number in range(TRIALS):
        for place, loop in enumerate(loops):
            times[place].clear()
            began = time.process_time()
            loop.run(number, SEED)
            whole[place] += time.process_time() - began
            physics[place] += sum(times[place])
            steps[place] += len(times[place])
    for place, name in enumerate(STEPS):
        step, cost, each = 1e6 * physics[place] / steps[place], physics[place] / TRIALS, whole[place] / TRIALS
        print(f"{name}: step {step:.0f} µs, a trial {each:.2f} s, its physics {cost:.2f} s")
    ratios = (physics / steps, physics, whole)
    said = (f"{what} {of[0] / of[1]:.1f}" for what, of in zip(("step", "physics", "trial"), ratios, strict=True))
    print(f"bullet over mujoco: {', '.join(said)}")


if __name__ == "__main__":
    main()
