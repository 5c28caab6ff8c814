"""How much of a tick the controller takes: one evaluation of π_s|Γ Γ (π_gx|Γ Γ) against ten steps of physics.

Prints the medians and their ratio. The floor is a tick of pure physics.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from pathlib import Path

import numpy as np

from graspdsl.compiler.program import program_of
from graspdsl.trials.setup import world_of
from graspdsl.worlds.protocol import Command
from graspdsl.worlds.start_pose import pose

SPEC = Path(__file__).resolve().parents[1] / "specs" / "towel_roll_two_contacts.yaml"
DRAWN = {"roll": 0.3, "yaw": 0.0, "tilt": 0.0, "height": 0.1, "standoff": 0.047, "offset": 0.0}
ROUNDS = 300


def median_time(action: Callable[[], object]) -> float:
    """The median time [s] of an action."""
    times = []
    for _ in range(ROUNDS):
        began = time.perf_counter()
        action()
        times.append(time.perf_counter() - began)
    return float(np.median(times))


def main() -> None:
    """Measure both and print their ratio."""
    program = program_of(SPEC.read_text("utf-8"), SPEC.name)
    world = world_of(program)
    surface = program.robot.hand.palm_surface
    start = pose("side", DRAWN, program.body, surface)
    (close,), (slide,) = program.pipelines()
    observation = world.reset(start, seed=0)
    while not observation.touching.all():
        observation = world.step(close.evaluate(observation).command)
    still = Command("q", np.zeros(len(world.info.joints)))
    controller = median_time(lambda: slide.evaluate(observation))
    tick = median_time(lambda: world.step(still))
    world.close()
    print(f"controller {1e6 * controller:.0f} µs, tick of physics and sensing {1e6 * tick:.0f} µs")
    print(f"ratio {controller / tick:.2f}")


if __name__ == "__main__":
    main()
