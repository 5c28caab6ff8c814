"""How little effort of Bullet's solver, and how few steps, keep forces and orientations what more of both would make
them: trials of the main spec, paired by number, against the same at the most effort.
"""

from __future__ import annotations

import time
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from importlib.util import find_spec
from pathlib import Path

import numpy as np
from measuring import Row

from graspdsl.compiler.program import program_of
from graspdsl.trials.outcomes import Outcome
from graspdsl.trials.record import TrialRecord
from graspdsl.trials.setup import trial_loop

SPEC = Path(__file__).resolve().parents[1] / "specs" / "towel_roll_two_contacts.yaml"
TRIALS, SEED = 4, 2006
MOST = 800  # iterations
EFFORTS: Mapping[str, str] = {
    "200 iterations": "{solver_iterations: 200}",
    "100 iterations": "{solver_iterations: 100}",
    "50 iterations": "{solver_iterations: 50}",
    "25 iterations": "{solver_iterations: 25}",
    "as the world has it": "{}",
}
FORCE, ORIENTATION = 0.02, 0.01  # of a force; rad


@dataclass(frozen=True)
class Trials:
    """Records by number, and the processor's time [s] of a tick in them."""

    records: Mapping[int, TrialRecord]
    tick: float


def rows() -> Iterator[Row]:
    """A row for each effort: its time over that of the most, and what is different then."""
    if find_spec("pybullet") is None:
        yield Row("Bullet at less effort", note="pybullet is not installed")
        return
    most = trials(f"{{solver_iterations: {MOST}}}")
    for name, effort in EFFORTS.items():
        found = trials(effort)
        yield Row(f"a tick of Bullet, {name} / {MOST}", found.tick / most.tick, note=difference(found, most))


def trials(effort: str) -> Trials:
    """The trials at an effort."""
    loop = trial_loop(program_of(SPEC.read_text("utf-8"), SPEC.name, (f"scene.physics={effort}", "scene.world=bullet")))
    began = time.process_time()
    records = {trial.record.number: trial.record for trial in loop.run_all(range(TRIALS), SEED)}
    ticks = sum(record.ticks for record in records.values())
    return Trials(records, (time.process_time() - began) / ticks)


def difference(found: Trials, most: Trials) -> str:
    """The largest and the median difference of those that settle at both efforts, in words."""
    pairs = [(found.records[number], record) for number, record in most.records.items()]
    settled = [pair for pair in pairs if all(record.outcome is Outcome.CONVERGED for record in pair)]
    if not settled:
        return f"none of {len(pairs)} trials converges at both"
    turned = [abs(one.orientation_end - other.orientation_end) for one, other in settled]
    forces = [np.array([one.contact_forces, other.contact_forces]) for one, other in settled]
    pressed = [float(np.max(np.abs(one - other) / np.abs(other))) for one, other in forces]
    keeps = max(turned) <= ORIENTATION and max(pressed) <= FORCE
    return (
        f"{len(settled)} of {len(pairs)} converge at both; orientation differs by {max(turned):.2g} rad (median "
        f"{np.median(turned):.2g}), a force by {100 * max(pressed):.2g} % (median {100 * np.median(pressed):.2g} %): "
        f"{'within' if keeps else 'not within'} {ORIENTATION} rad and {100 * FORCE:g} %"
    )
