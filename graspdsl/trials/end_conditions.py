"""End conditions of a stage, as the hand senses them: whether they hold, and what is said of those that do not."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from graspdsl.arrays import Array, Flags
from graspdsl.basis.algebra import length
from graspdsl.compiler.pipeline import Ticks
from graspdsl.diagnostics import listed
from graspdsl.spec.program import Until

LEAST_DIGITS, MOST_DIGITS = 3, 6


@dataclass(frozen=True, slots=True)
class Bounded:
    """What a bound can be given for: its ``name`` in words, how it is ``measured`` in ticks, (...), NaN where it is
    not, its ``unit`` in words and how many of these make one of the spec's."""

    name: str
    measured: Callable[[Ticks], Array]
    unit: str = ""
    scale: float = 1.0

    def said(self, value: float, bound: float | None = None) -> str:
        """A value with its unit, and with as many digits as tell it from the bound, three at least."""
        if bound is None:
            return f"{self.scale * value:g}{self.unit}"
        texts = [f"{self.scale * value:.{digits}g}" for digits in range(LEAST_DIGITS, MOST_DIGITS + 1)]
        return next((text for text in texts if float(text) != self.scale * bound), texts[-1]) + self.unit


BOUNDED: Mapping[str, Bounded] = {
    "force_residual": Bounded("‖ρ_f‖", lambda ticks: length(ticks.force_residual)),
    "moment_residual": Bounded("‖ρ_m‖", lambda ticks: length(ticks.moment_residual), " mm", 1000.0),
    "force_error": Bounded("the largest error of a contact force", lambda ticks: ticks.force_error, " N"),
}
"""By the names of the spec."""


def bounded(until: Until, ticks: Ticks) -> Iterator[tuple[str, Array, float]]:
    """The names of the conditions that are given, with the values (...) and the bound of each."""
    for name, kind in BOUNDED.items():
        if (bound := getattr(until, name)) is not None:
            yield name, kind.measured(ticks), bound


def is_low(until: Until, ticks: Ticks) -> Flags:
    """Whether residuals and force error are below their bounds, those that are given and can be measured, (...)."""
    low = np.ones(ticks.force_residual.shape[:-1], dtype=bool)
    for _, values, bound in bounded(until, ticks):
        low &= ~(values >= bound)
    return low


def unmet(until: Until, ticks: Ticks, away: Sequence[str]) -> str:
    """Every condition that does not hold at a tick of one trial, with its value and bound; nothing where all hold.

    away: the names of the contacts that do not touch.
    """
    said = [f"{listed(away)} {'does' if len(away) == 1 else 'do'} not touch"] if away else []
    for name, values, bound in bounded(until, ticks):
        value, told = float(values.item()), BOUNDED[name]
        if value >= bound:
            said.append(f"{told.name} = {told.said(value, bound)}, not below {told.said(bound)}")
    return ", and ".join(said)
