"""Draw the figure of posture optimization: finger joints while sliding over a ball, with π_sq and with π_s.

Run it with the developers' tools installed: python docs/render_posture.py
"""

from __future__ import annotations

from pathlib import Path

import matplotlib as mpl
import numpy as np

mpl.use("Agg")
from matplotlib import pyplot as plt

from graspdsl.arrays import Float32Array
from graspdsl.compiler.program import program_of
from graspdsl.trials.setup import trial_loop

ROOT = Path(__file__).resolve().parent.parent
SPECS = {
    "with the posture term, π_sq (Eq. 4.26)": "specs/chapter/4_26_slide_with_posture.yaml",
    "without it, π_s (Eq. 4.24)": "specs/compare/slide_without_posture.yaml",
}
BAND = 0.15  # rad about the middle of the range


def trajectory(spec: str) -> dict[str, Float32Array]:
    """The trajectory of the spec's first trial."""
    program = program_of((ROOT / spec).read_text("utf-8"), spec)
    return dict(trial_loop(program).run(0, program.spec.trials.seed).trajectory)


def main() -> None:
    """Draw both trials side by side."""
    figure, axes = plt.subplots(1, 2, figsize=(9, 3.4), sharey=True, layout="constrained")
    middle = 2.443 / 2
    for axis, (title, spec) in zip(axes, SPECS.items(), strict=True):
        rows = trajectory(spec)
        sliding = rows["phase"] == 2
        time = rows["time"][sliding]
        axis.axhspan(middle - BAND, middle + BAND, color="0.9", label="mid-range ± 0.15 rad")
        for finger in range(3):
            axis.plot(time, rows["joints"][sliding, 7 + finger], label=f"finger {finger + 1}")
        touching = float(np.mean(rows["touching"][sliding]))
        axis.set_title(f"{title}\ncontacts touch {100 * touching:.0f} % of the time", fontsize=9)
        axis.set_xlabel("time [s]")
    axes[0].set_ylabel("flexion of the finger [rad]")
    axes[0].legend(fontsize=8, loc="lower right")
    figure.savefig(ROOT / "docs/images/posture.png", dpi=110)


if __name__ == "__main__":
    main()
