"""The end conditions of a stage as the hand senses them: whether they are met, and in words which are not."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from graspdsl.compiler.pipeline import Tick
from graspdsl.diagnostics import listed
from graspdsl.spec.program import Until

LEAST_DIGITS, MOST_DIGITS = 3, 6


def is_low(until: Until, tick: Tick) -> bool:
    """Whether residuals and force error are below their bounds, those that are given and can be measured."""
    return not _too_high(until, tick)


def unmet(until: Until, tick: Tick, away: Sequence[str]) -> str:
    """Every condition that does not hold at a tick, with its value and bound; nothing where all hold.

    away: the names of the contacts that do not touch.
    """
    said = [f"{listed(away)} {'does' if len(away) == 1 else 'do'} not touch"] if away else []
    for name, (value, bound) in _too_high(until, tick).items():
        match name:
            case "force_residual":
                said.append(f"‖ρ_f‖ = {_apart(value, bound)}, not below {bound:g}")
            case "moment_residual":
                said.append(f"‖ρ_m‖ = {_apart(1000 * value, 1000 * bound)} mm, not below {1000 * bound:g} mm")
            case _:
                error = _apart(value, bound)
                said.append(f"a contact force is {error} N from its reference, not below {bound:g} N")
    return ", and ".join(said)


def _apart(value: float, bound: float) -> str:
    """A value with as many digits as tell it from the bound that it is not below, three at least."""
    texts = [f"{value:.{digits}g}" for digits in range(LEAST_DIGITS, MOST_DIGITS + 1)]
    return next((text for text in texts if float(text) > bound), texts[-1])


def _too_high(until: Until, tick: Tick) -> dict[str, tuple[float, float]]:
    """Value and bound of each condition that is measured and not below its bound, by the names of the spec."""
    measured = {
        "force_residual": float(np.linalg.norm(tick.force_residual)),
        "moment_residual": float(np.linalg.norm(tick.moment_residual)),
        "force_error": tick.force_error,
    }
    bounds = {name: getattr(until, name) for name in measured}
    return {
        name: (value, bounds[name])
        for name, value in measured.items()
        if bounds[name] is not None and value >= bounds[name]
    }
