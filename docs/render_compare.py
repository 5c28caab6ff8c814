"""Write docs/compare.md: controllers of the chapter side by side on the same starts, and which of them are the same.

Run it with the developers' tools installed: python docs/render_compare.py. It takes some twenty minutes.
"""

from __future__ import annotations

import tempfile
from collections.abc import Iterator, Sequence
from itertools import combinations
from pathlib import Path

import numpy as np

from graspdsl.compiler.program import program_of
from graspdsl.report.comparison import pairs_of
from graspdsl.report.evidence import Evidence, evidence_of
from graspdsl.report.sameness import said_of, sameness_table, samenesses
from graspdsl.report.statistics import median
from graspdsl.report.wording import NOTHING, percent
from graspdsl.trials.outcomes import Outcome
from graspdsl.trials.runner import execute, new_run

ROOT = Path(__file__).resolve().parent.parent
SPECS, PAGE = ROOT / "specs" / "compare", ROOT / "docs" / "compare.md"
TRIALS, SEED = 300, 60911
RADIUS = 0.05  # m: r
LOW = 1e-2  # ε, and ε over r² of moments
AT_REST = 1e-6  # m a tick

CONTROLLERS = {
    "moment_subject_to_force": "mr ◁ fr",
    "force_subject_to_moment": "fr ◁ mr",
    "force_alone": "fr alone",
    "cstar": "C\\*: fr then mr",
    "cstar_hysteresis": "C\\* with hysteresis",
    "naive_wrench": "φ_w, by the models",
    "true_wrench": "φ_w, the true surface",
}
OBJECTS = {"A (1, 1.2, 1.5)": (1.0, 1.2, 1.5), "B (1, 1.5, 2.2)": (1.0, 1.5, 2.2)}  # half axes, of r
MOVING = {"three contacts": "{γ1, γ2, γ3}", "three contacts, γ1 held fixed": "{γ2, γ3}"}

HEAD = """# Controllers side by side

Made by `docs/render_compare.py`: {trials} starts of seed {seed}, the same for every controller, contacts that float on
an ellipsoid whose half axes are given in units of r = 5 cm. A trial ends when ‖ρ_f‖ < 0.1 and ‖ρ_m‖ < 5 mm have held
for 0.4 s, or after 1000 ticks; the monitor of progress is off, so that nothing else ends it.

- *undone*: a later stage of C\\* raised what an earlier one had lowered.
- *at rest*: not converged, and no contact moves by a micrometre a tick any more: for the last controller, a local
  minimum of ε_w itself.
- Neither converged nor at rest: still on its way, or going to and fro, as descent by steps of a fixed gain does where a
  surface is sharply curved, and as priorities do that pull two ways.
- *ε_fr*, *ε_mr/r²*: the share of all trials whose squared residual is below 10⁻² at their end.
- *same as*: the controllers by number whose contacts are, at every tick of every trial, where those of this one are,
  but for rounding. The squares below say it of every pair: *same*, or the share of trials that part and the median of
  the first ticks at which they do.

Where all contacts move, with equal weights, ◁ is a plain sum: mr ◁ fr, fr ◁ mr and φ_w by the models are one
controller, as `graspdsl explain` says before anything runs. A comparison of them says nothing of priorities. Where γ1
is held fixed the gradients are not at right angles any more, and the order matters.

φ_w by the models (`τ_wx`) takes the surface for a sphere where force is concerned and for a plane where moment is;
`τ_wsx` goes down the gradient of ε_w over the surface as it is. Only of the latter is a place of rest a local minimum
of ε_w.
"""

TAIL = """
## To repeat a row

<!-- shown: a minute a row -->
```sh
graspdsl run specs/compare/cstar.yaml --trials {trials} --seed {seed} --out cstar \\
    --set 'scene.object.ellipsoid.size=[0.10, 0.12, 0.15]' --set 'resources.Γ_τ="{{γ2, γ3}}"' \\
    --set monitors.progress=off
graspdsl compare cstar …
```
"""


def overrides(half_axes: Sequence[float], moving: str, trials: int, seed: int) -> tuple[str, ...]:
    """The changes of a spec for one of the cases."""
    size = [2.0 * RADIUS * axis for axis in half_axes]
    return (
        f"scene.object.ellipsoid.size={size}",
        f'resources.Γ_τ="{moving}"',
        f"trials.count={trials}",
        f"trials.seed={seed}",
        "monitors.progress=off",
    )


def ran(place: Path, settings: tuple[str, ...]) -> Iterator[Evidence]:
    """Every controller's run in a case."""
    for name in CONTROLLERS:
        path = SPECS / f"{name}.yaml"
        folder = new_run(place / name, program_of(path.read_text("utf-8"), path.name, settings))
        execute(folder, workers=1)
        yield evidence_of(folder)


def rests(evidence: Evidence) -> float:
    """The share of trials that have not converged and do not move any more."""

    def at_rest(number: int) -> bool:
        points = evidence.folder.trajectory(number)["points"][-2:].astype(np.float64)
        return float(np.linalg.norm(np.diff(points, axis=0), axis=-1).max()) < AT_REST

    open_ones = [record.number for record in evidence.records if record.outcome is not Outcome.CONVERGED]
    return sum(map(at_rest, open_ones)) / len(evidence.records)


def row(number: int, label: str, evidence: Evidence, same: Sequence[int]) -> str:
    """One controller's line."""
    records = evidence.records
    ended = [sum(record.outcome is outcome for record in records) for outcome in (Outcome.CONVERGED, Outcome.UNDONE)]
    force = np.mean([record.force_residual_end**2 < LOW for record in records])
    moment = np.mean([(record.moment_residual_end / RADIUS) ** 2 < LOW for record in records])
    shares = [*(found / len(records) for found in ended), rests(evidence), float(force), float(moment)]
    ticks = median(record.ticks_to_converge for record in records if record.ticks_to_converge is not None)
    cells = [str(number), label, *map(percent, shares), NOTHING if ticks is None else f"{ticks:.0f}"]
    return f"| {' | '.join([*cells, ', '.join(map(str, same)) or NOTHING])} |"


def case(runs: Sequence[Evidence]) -> list[str]:
    """The lines of a case: a row for each controller, what is said of them, and a square of pairs."""
    found = samenesses(runs, {(i, j): pairs_of(runs[i], runs[j]) for i, j in combinations(range(len(runs)), 2)})
    same: dict[int, list[int]] = {number: [] for number in range(1, len(runs) + 1)}
    for pair in found:
        if pair.is_same:
            one, other = pair.runs
            same[one].append(other)
            same[other].append(one)
    heads = ("", "controller", "converged", "undone", "at rest", "ε_fr", "ε_mr/r²", "ticks", "same as")
    lines = [f"| {' | '.join(heads)} |", "|---|---|" + "---:|" * 7]
    lines += [row(i, label, runs[i - 1], sorted(same[i])) for i, label in enumerate(CONTROLLERS.values(), 1)]
    square = sameness_table(found, [str(number) for number in same])
    lines += ["", f"| {' | '.join(column.label for column in square.columns)} |", "|---|" + "---:|" * (len(runs) - 1)]
    lines += [f"| {' | '.join(cell.text for cell in cells)} |" for cells in square.cells()]
    return [*lines, "", *said_of(found)]


def page(trials: int = TRIALS, seed: int = SEED) -> str:
    """The whole page."""
    lines = [HEAD.format(trials=trials, seed=seed)]
    for moved, moving in MOVING.items():
        for name, half_axes in OBJECTS.items():
            with tempfile.TemporaryDirectory() as place:
                runs = list(ran(Path(place), overrides(half_axes, moving, trials, seed)))
                lines += [f"## Ellipsoid {name}, {moved}", "", *case(runs), ""]
    return "\n".join(lines).rstrip() + "\n" + TAIL.format(trials=trials, seed=seed)


if __name__ == "__main__":
    PAGE.write_text(page(), encoding="utf-8")
