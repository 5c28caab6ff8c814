"""How numbers of a report are written, on a page as on a terminal."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

NOTHING = "–"


def percent(share: float | None) -> str:
    """A share in percent, or a dash."""
    return NOTHING if share is None else f"{100 * share:.0f} %"


def percents(interval: Sequence[float]) -> str:
    """An interval of shares, in percent."""
    low, high = interval
    return f"{percent(low)} to {percent(high)}"


def number(value: float | None, unit: str, digits: int) -> str:
    """A number with its unit, or a dash."""
    return NOTHING if value is None else f"{value:.{digits}f} {unit}".rstrip()


def millimetres(metres: float | None, digits: int = 1) -> str:
    """A length given in m, in mm."""
    return number(None if metres is None else 1000 * metres, "mm", digits)


def quantiles(values: Sequence[float] | None, unit: str) -> str:
    """Quantiles of a number that a start has, in its unit."""
    return NOTHING if values is None else f"{'  '.join(f'{value:.3g}' for value in values)} {unit}".rstrip()


def counted(count: int, one: str, many: str) -> str:
    """A count with its noun."""
    return f"{count} {one if count == 1 else many}"


def feasible(starts: Mapping[str, Any]) -> str:
    """On what starts the shares of a run are conditional; nothing where every start that was drawn began a trial."""
    draws, kept = starts["draws"], starts["kept"]
    if draws == kept:
        return ""
    return f"of feasible starts only: {draws - kept} of {counted(draws, 'draw', 'draws')} could not be taken up"


def repetition(trials: Mapping[str, int]) -> str | None:
    """What trials that repeat others mean for the intervals; None where all may differ."""
    finished, different = trials["finished"], trials["different"]
    if different == finished:
        return None
    if different == 1:
        return f"Nothing differs between these {finished} trials: they count as one, and the intervals say nothing."
    return f"Only {different} of these {finished} trials can differ: intervals take the others, repeats, as trials too."


def conditions(means: Mapping[str, Any]) -> str:
    """What the end conditions of a phase ask for, in words."""
    said = []
    if means["force_residual"] is not None:
        said.append(f"‖ρ_f‖ < {means['force_residual']:g}")
    if means["moment_residual"] is not None:
        said.append(f"‖ρ_m‖ < {1000 * means['moment_residual']:g} mm")
    if means["force_error"] is not None:
        said.append(f"forces ± {means['force_error']:g} N")
    said.append("all touching")
    return f"{', '.join(said)}, for {means['hold']:g} s"
