"""Draw how the success of Experiment 1 falls as its sensors become noisier: docs/images/success_against_noise.svg.

Run it with the developers' tools installed: python docs/render_sensing.py. It takes some minutes.
"""

from __future__ import annotations

import math
import multiprocessing
from collections.abc import Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from pathlib import Path

import matplotlib

matplotlib.use("svg")
from matplotlib import pyplot

from graspdsl.compiler.program import program_of
from graspdsl.report.statistics import wilson
from graspdsl.trials.record import TrialRecord
from graspdsl.trials.setup import trial_loop

ROOT = Path(__file__).resolve().parent.parent
SPEC = ROOT / "specs" / "towel_roll_two_contacts.yaml"
STARTS = "trials.start.roll={uniform: [-0.85, 0.85]}"  # rad: orientations that begin above 0.7 rad
TRIALS, SEED, WORKERS = 12, 2007, 1
LEVER = 0.01  # m: noise of the moment for a unit of noise of the force


@dataclass(frozen=True)
class Series:
    """One curve: its levels of noise [N] and what each puts in the spec."""

    name: str
    levels: Sequence[float]
    setting: str
    colour: str

    def overrides(self, level: float) -> tuple[str, ...]:
        """The spec's changes for one level of noise."""
        return (STARTS, "scene.sensing=" + self.setting.format(noise=level, moment=LEVER * level))


PANELS = {
    "load cell: noise of a sample [mN; a hundredth of it in mN·m]": (
        Series(
            "500 Hz, averaged and filtered (the default)",
            (0.0, 0.02, 0.05, 0.1, 0.2),
            "{{load-cell: {{force_noise: {noise:g}, moment_noise: {moment:g}, latency: 0.02}}}}",
            "#1f6f8b",
        ),
        Series(
            "one raw sample a control tick",
            (0.005, 0.02, 0.05, 0.1),
            "{{load-cell: {{force_noise: {noise:g}, moment_noise: {moment:g}, latency: 0.02, rate: 50, filter: 0}}}}",
            "#c8553d",
        ),
    ),
    "skin: noise of a taxel's sample [mN]": (
        Series(
            "taxels 2 mm apart, 100 Hz",
            (0.0, 0.002, 0.005, 0.01, 0.02),
            "{{skin: {{taxel_noise: {noise:g}, latency: 0.02}}}}",
            "#1f6f8b",
        ),
    ),
}


def succeeded(record: TrialRecord) -> bool:
    """Whether a trial ended in a good grasp by the simulator's truth, whatever was sensed of it."""
    upright = abs(record.orientation_end - math.pi / 2) < 0.05
    return record.force_residual_end < 0.1 and record.moment_residual_end < 0.005 and upright


def successes(overrides: tuple[str, ...]) -> int:
    """How many of the trials of one level succeed."""
    loop = trial_loop(program_of(SPEC.read_text("utf-8"), SPEC.name, overrides))
    return sum(succeeded(loop.run(number, SEED).record) for number in range(TRIALS))


def counted() -> list[int]:
    """Run all levels; the successes of each, in the order of the panels."""
    every = [series for panel in PANELS.values() for series in panel]
    wanted = [series.overrides(level) for series in every for level in series.levels]
    with ProcessPoolExecutor(WORKERS, mp_context=multiprocessing.get_context("spawn")) as pool:
        return list(pool.map(successes, wanted))


def draw(successes_by_level: list[int]) -> None:
    """Draw the figure: shares with their Wilson intervals against noise in mN."""
    counts = iter(successes_by_level)
    figure, axes = pyplot.subplots(1, len(PANELS), figsize=(9.0, 3.4), sharey=True, layout="constrained")
    for axis, (label, panel) in zip(axes, PANELS.items(), strict=True):
        for series in panel:
            found = [next(counts) for _ in series.levels]
            noise = [1000.0 * level for level in series.levels]
            lows, highs = zip(*(wilson(count, TRIALS) for count in found), strict=True)
            axis.fill_between(noise, lows, highs, color=series.colour, alpha=0.15, linewidth=0)
            axis.plot(noise, [count / TRIALS for count in found], "o-", color=series.colour, label=series.name)
        axis.set_xlabel(label)
        axis.set_ylim(0.0, 1.02)
        axis.grid(alpha=0.3)
        axis.legend(frameon=False, loc="upper center", bbox_to_anchor=(0.5, 1.24), fontsize="small")
    axes[0].set_ylabel(f"good grasps of {TRIALS}")
    pyplot.rcParams["svg.hashsalt"] = "graspdsl"
    figure.savefig(ROOT / "docs" / "images" / "success_against_noise.svg", metadata={"Date": None})


if __name__ == "__main__":
    draw(counted())
