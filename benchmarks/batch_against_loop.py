"""What it gains to run floating trials side by side: trial-steps a second of a run against the same trials one by one.

Prints both rates and their ratio for several numbers of trials.
"""

from __future__ import annotations

import time
from pathlib import Path

from graspdsl.compiler.program import program_of
from graspdsl.trials.setup import trial_loop

SPEC = Path(__file__).resolve().parents[1] / "specs" / "chapter" / "4_30_grasp_cartesian.yaml"
SINGLES = 20


def main() -> None:
    """Measure and print."""
    loop = trial_loop(program_of(SPEC.read_text("utf-8"), SPEC.name))

    def rate(trials: int, together: int) -> float:
        """Trial-steps a second, records and trajectories included."""
        loop.together = together
        began = time.perf_counter()
        steps = sum(len(trial.trajectory["time"]) for trial in loop.run_all(range(trials), 0))
        return steps / (time.perf_counter() - began)

    one_by_one = rate(SINGLES, 1)
    print(f"one by one: {one_by_one:.0f} trial-steps/s")
    for together in (8, 64, 512):
        batched = rate(4 * together, together)
        print(f"{together} side by side: {batched:.0f} trial-steps/s, ratio {batched / one_by_one:.0f}")


if __name__ == "__main__":
    main()
