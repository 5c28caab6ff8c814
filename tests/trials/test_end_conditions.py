"""End conditions in words: those that do not hold, and no others."""

from __future__ import annotations

import math

import numpy as np
import pytest

from graspdsl.compiler.pipeline import Tick
from graspdsl.spec.program import Until
from graspdsl.trials.end_conditions import is_low, unmet
from graspdsl.worlds.protocol import Command

BOUNDS = Until(force_residual=0.1, moment_residual=0.005, force_error=0.1)


def tick(force: float, moment: float, error: float = 0.0) -> Tick:
    """A tick whose sensed residuals have these norms."""
    along = np.array([0.6, 0.0, -0.8])
    return Tick(Command("q", np.zeros(1)), force * along, moment * along, error, (), (), np.zeros(1, dtype=bool))


@pytest.mark.parametrize(
    ("now", "said"),
    [
        (tick(0.01, 0.0056), "‖ρ_m‖ = 5.6 mm, not below 5 mm"),
        (tick(0.01, 0.005003), "‖ρ_m‖ = 5.003 mm, not below 5 mm"),
        (tick(0.25, 0.001), "‖ρ_f‖ = 0.25, not below 0.1"),
        (tick(0.25, 0.0056), "‖ρ_f‖ = 0.25, not below 0.1, and ‖ρ_m‖ = 5.6 mm, not below 5 mm"),
        (tick(0.01, 0.001, 0.3), "a contact force is 0.3 N from its reference, not below 0.1 N"),
        (tick(0.01, 0.001, math.nan), ""),
        (tick(0.01, 0.001), ""),
    ],
)
def test_what_is_not_met_is_named_with_its_bound(now: Tick, said: str) -> None:
    assert unmet(BOUNDS, now, []) == said
    assert is_low(BOUNDS, now) is (said == "")


def test_what_is_not_waited_for_is_not_named() -> None:
    assert unmet(Until(moment_residual=0.005), tick(9.0, 0.001, 9.0), []) == ""


def test_contacts_that_do_not_touch_are_named_first() -> None:
    now = tick(0.25, 0.0)
    assert unmet(BOUNDS, now, ["finger-1"]) == "finger-1 does not touch, and ‖ρ_f‖ = 0.25, not below 0.1"
    assert unmet(Until(contact="all"), now, ["finger-1", "finger-3"]) == "finger-1 and finger-3 do not touch"
