"""What a second worker is worth: the same run of MuJoCo trials by one process and by two."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator
from pathlib import Path

from measuring import Row, in_turn, medians, ratio_of

import graspdsl

SPEC = Path(__file__).resolve().parents[1] / "specs" / "towel_roll_two_contacts.yaml"
TRIALS, ROUNDS = 96, 2


def rows() -> Iterator[Row]:
    """One against two."""
    what, bound = f"{TRIALS} trials of the main spec in mujoco: one worker / two", "≥ 1.8"
    cores = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
    if cores < 2:
        yield Row(what, bound=bound, note="there is one core")
        return
    times = in_turn({"one": run_by(1), "two": run_by(2)}, ROUNDS, warm=False)
    yield ratio_of(what, times["one"], times["two"], bound, medians(times))


def run_by(workers: int) -> Callable[[], object]:
    """A run by so many workers, from the checked spec to the last record."""
    program = graspdsl.load(SPEC, set=["scene.world=mujoco"])

    def run() -> object:
        return graspdsl.run(program, trials=TRIALS, workers=workers, progress=False)

    return run
