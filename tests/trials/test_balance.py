"""The balance of final grasps: what the simulator says of a pinch afloat, which nothing but its contacts holds."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from graspdsl.arrays import Array
from graspdsl.compiler.program import program_of
from graspdsl.trials.outcomes import Outcome
from graspdsl.trials.record import Trial
from graspdsl.trials.rows import record_of, row_of
from graspdsl.trials.setup import trial_loop

AFLOAT = Path(__file__).parents[2] / "specs" / "pinch_afloat.yaml"
NOTHING = (0.0,) * 6


def pinched(*overrides: str) -> Trial:
    """A trial of a pinch afloat."""
    program = program_of(AFLOAT.read_text("utf-8"), AFLOAT.name, ("program.0.limit=8", *overrides))
    return trial_loop(program).run(0, 31)


def sizes(trial: Trial) -> Array:
    """The forces (3,) [N] of finger-1, finger-2 and the thumb, at the end."""
    return np.linalg.norm(trial.trajectory["forces"][-1], axis=-1)


@pytest.mark.slow
def test_shared_forces_balance_and_others_carry_the_object_off() -> None:
    """Two fingers with all of the force each have a thumb with as much give way; physics lets them not be unequal."""
    shared, alike = pinched(), pinched("control.virtual_forces=alike")
    assert shared.record.outcome is Outcome.CONVERGED
    assert sizes(shared) == pytest.approx([0.25, 0.25, 0.5], abs=0.01)
    assert shared.record.object_shift < 1e-3
    balance = shared.record.balance
    assert balance is not None
    assert np.abs(balance.contacts).max() < 1e-3
    assert balance.links == balance.table == balance.gravity == NOTHING
    assert alike.record.outcome is Outcome.TIMEOUT
    first, second, thumb = sizes(alike)
    assert first + second == pytest.approx(thumb, abs=0.01)
    assert alike.record.object_shift > 10.0 * shared.record.object_shift


@pytest.mark.slow
def test_a_balance_is_the_mean_while_the_conditions_held() -> None:
    trial = pinched("program.0.until.hold=0.4")
    loads = trial.trajectory["loads"]
    balance = trial.record.balance
    assert balance is not None
    np.testing.assert_allclose(balance.contacts, loads[-21:, 0].mean(axis=0), atol=1e-6)  # 0.4 s of 50 Hz
    assert not np.allclose(balance.contacts, loads[-50:, 0].mean(axis=0), atol=1e-6)
    assert record_of(row_of(trial.record)) == trial.record
