"""What was said of trials, alike but for its numbers, is one entry of an outcome."""

from __future__ import annotations

import math

from graspdsl.report.outcomes import outcome_table
from graspdsl.trials.outcomes import Outcome
from graspdsl.trials.record import TrialRecord


def ended(number: int, detail: str) -> TrialRecord:
    """A trial that ran out of time."""
    unknown = dict.fromkeys(TrialRecord.__annotations__, math.nan)
    return TrialRecord(**{**unknown, "number": number, "outcome": Outcome.TIMEOUT, "detail": detail})


def said(*details: str) -> list[tuple[str, list[int]]]:
    """The entries of trials with these details."""
    [row] = outcome_table([ended(number, detail) for number, detail in enumerate(details)])
    return [(entry.detail, list(entry.trials)) for entry in row.details]


def test_unmet_conditions_are_grouped_by_what_was_unmet_the_commonest_first() -> None:
    assert said(
        "not converged within 30 s: ‖ρ_f‖ = 0.25, not below 0.1",
        "not converged within 30 s: ‖ρ_m‖ = 5.6 mm, not below 5 mm",
        "not converged within 30 s: ‖ρ_m‖ = 12 mm, not below 5 mm",
    ) == [
        ("not converged within 30 s: ‖ρ_m‖ = 5.6 to 12 mm, not below 5 mm", [1, 2]),
        ("not converged within 30 s: ‖ρ_f‖ = 0.25, not below 0.1", [0]),
    ]


def test_small_and_large_numbers_are_grouped_too() -> None:
    details = ("‖ρ_f‖ = 3e-05, not below 1e-05", "‖ρ_f‖ = 0.002, not below 1e-05", "‖ρ_f‖ = 1.2e+03, not below 1e-05")
    assert said(*details) == [("‖ρ_f‖ = 3e-05 to 1.2e+03, not below 1e-05", [0, 1, 2])]


def test_names_with_numbers_are_told_apart() -> None:
    assert len(said("finger-1 made no contact within 3 s", "finger-2 made no contact within 3 s")) == 2
