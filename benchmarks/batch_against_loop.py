"""What a batch of floating trials gains: steps a second in one batch against the same trials one by one.

Prints both rates and their ratio for several batch sizes.
"""

from __future__ import annotations

import time
from pathlib import Path

import numpy as np

from graspdsl.compiler.program import program_of
from graspdsl.trials.batch import run_batch

SPEC = Path(__file__).resolve().parents[1] / "specs" / "chapter" / "4_30_grasp_cartesian.yaml"
STEPS = 20
SINGLES = 20


def main() -> None:
    """Measure and print."""
    program = program_of(SPEC.read_text("utf-8"), SPEC.name)
    surface = program.body.shape.surface()
    (pipelines,) = program.pipelines()
    contacts = len(program.robot.contacts)

    def rate(starts: int, batches: int) -> float:
        """Trial-steps a second."""
        random = np.random.default_rng(0)
        points = [surface.sample(starts * contacts, random).reshape(starts, contacts, 3) for _ in range(batches)]
        began = time.perf_counter()
        for here in points:
            run_batch(pipelines, surface, here, force_bound=0.0, moment_bound=0.0, steps=STEPS, stop=False)
        return starts * batches * STEPS / (time.perf_counter() - began)

    one_by_one = rate(1, SINGLES)
    print(f"one by one: {one_by_one:.0f} trial-steps/s")
    for count in (100, 1000, 10_000):
        batched = rate(count, 1)
        print(f"batch of {count}: {batched:.0f} trial-steps/s, ratio {batched / one_by_one:.0f}")


if __name__ == "__main__":
    main()
