"""How everything here is measured: what is compared runs in turn, and what is told is the median of ratios.

The machine may be slower now than a second ago; it is hardly slower for one of two things that follow each other.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

Times = Mapping[str, npt.NDArray[np.float64]]


@dataclass(frozen=True)
class Row:
    """A line of the table. ``ratio``: None where it could not be measured, and ``note`` says why; ``bound``: what it
    must keep to, "≤ 0.8", or nothing; ``spread``: its quartiles over the rounds, or nothing."""

    what: str
    ratio: float | None = None
    bound: str = ""
    spread: tuple[float, float] | None = None
    note: str = ""

    @property
    def holds(self) -> bool | None:
        """Whether the bound is kept; None where there is none, or no ratio."""
        if self.ratio is None or not self.bound:
            return None
        sign, number = self.bound.split()
        return self.ratio <= float(number) if sign == "≤" else self.ratio >= float(number)


def in_turn(
    actions: Mapping[str, Callable[[], object]], rounds: int, each: int = 1, within: float = 60.0, *, warm: bool = True
) -> Times:
    """The time [s] of each action in each round: (rounds,) by name.

    In a round every action has its turn, and runs ``each`` times, of which the mean counts; ``warm``: there is a first
    round that does not. No round begins after ``within`` [s] but for the first three.
    """
    times: dict[str, list[float]] = {name: [] for name in actions}
    first = time.perf_counter()
    for number in range(rounds + warm):
        if number > 2 and time.perf_counter() - first > within:
            break
        for name, action in actions.items():
            began = time.perf_counter()
            for _ in range(each):
                action()
            taken = (time.perf_counter() - began) / each
            if number or not warm:
                times[name].append(taken)
    return {name: np.array(taken) for name, taken in times.items()}


def ratio_of(what: str, taken: npt.NDArray[np.float64], by: npt.NDArray[np.float64], bound: str, note: str = "") -> Row:
    """The row of one time over another, round by round."""
    ratios = taken / by
    low, middle, high = np.quantile(ratios, [0.25, 0.5, 0.75])
    return Row(what, float(middle), bound, (float(low), float(high)), note)


def told(seconds: float) -> str:
    """A time in words, with three digits."""
    for unit, size in (("s", 1.0), ("ms", 1e-3)):
        if seconds >= size:
            return f"{seconds / size:.3g} {unit}"
    return f"{1e6 * seconds:.3g} µs"


def medians(times: Times) -> str:
    """The median of each, in words."""
    return ", ".join(f"{name} {told(float(np.median(taken)))}" for name, taken in times.items())


def exponent(sizes: npt.ArrayLike, times: npt.ArrayLike) -> float:
    """The p of times ~ sizes^p, by least squares of the logarithms."""
    return float(np.polyfit(np.log(np.asarray(sizes, float)), np.log(np.asarray(times, float)), 1)[0])
