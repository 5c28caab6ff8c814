"""The four experiments on MuJoCo against Bullet, one after the other: the wall time of whole graded runs, by as many
workers as they take by themselves.

``python benchmarks/experiments.py 4`` has four trials of each, ``all`` of them as many as the specs say.
"""

from __future__ import annotations

import sys
import time
from importlib.util import find_spec
from pathlib import Path

from measuring import told

import graspdsl

EXPERIMENTS = sorted((Path(__file__).resolve().parents[1] / "specs" / "experiments").glob("*.yaml"))
SAMPLE = 4
ENGINES = {"mujoco": "mujoco", "bullet": "pybullet"}


def main(trials: int | None) -> None:
    """Run and print."""
    whole = dict.fromkeys(ENGINES, 0.0)
    missing = [module for module in ENGINES.values() if find_spec(module) is None]
    if missing:
        sys.exit(f"not measured: {missing[0]} is not installed")
    for spec in EXPERIMENTS:
        taken = {world: seconds(spec, world, trials) for world in ENGINES}
        whole = {world: whole[world] + taken[world] for world in ENGINES}
        print(said(spec.stem, taken), flush=True)
    print(said("together", whole))


def seconds(spec: Path, world: str, trials: int | None) -> float:
    """The wall time [s] of a run."""
    program = graspdsl.load(spec, set=[f"scene.world={world}"])
    began = time.perf_counter()
    graspdsl.run(program, trials=trials, progress=False)
    return time.perf_counter() - began


def said(name: str, taken: dict[str, float]) -> str:
    """Times and their ratio, in words."""
    times = ", ".join(f"{world} {told(one)}" for world, one in taken.items())
    return f"{name}: {times}, mujoco / bullet {taken['mujoco'] / taken['bullet']:.3g}"


if __name__ == "__main__":
    asked = sys.argv[1] if len(sys.argv) > 1 else str(SAMPLE)
    main(None if asked == "all" else int(asked))
