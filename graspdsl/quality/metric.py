"""What a measure of grasp quality answers: a number, or why there is none."""

from __future__ import annotations

from dataclasses import dataclass

NO_CONTACTS = "no contacts"
CRASHED = "the simulation failed"


@dataclass(frozen=True, slots=True)
class Metric:
    """A value, with a reason where it is zero or None; an empty reason where it speaks for itself.

    Zero: measured, and there is nothing of it. None: there was nothing to measure.
    """

    value: float | None
    reason: str = ""
