"""How numbers of a report are written, on a page as on a terminal."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from graspdsl.report.start_selection import Starts
    from graspdsl.spec.program import Until

NOTHING = "–"
STOPPED = "stopped by a monitor"


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


def counted(count: int, one: str, many: str) -> str:
    """A count with its noun."""
    return f"{count} {one if count == 1 else many}"


def feasible(starts: Starts) -> str:
    """On what starts the shares of a run are conditional; nothing where every start that was drawn began a trial."""
    draws, kept = starts.draws, starts.kept
    if draws == kept:
        return ""
    return f"of feasible starts only: {draws - kept} of {counted(draws, 'draw', 'draws')} could not be taken up"


def repetition(finished: int, different: int) -> str | None:
    """What trials that repeat others mean for the intervals; None where all may differ."""
    if different == finished:
        return None
    if different == 1:
        return f"Nothing differs between these {finished} trials: they count as one, and the intervals say nothing."
    return f"Only {different} of these {finished} trials can differ: intervals take the others, repeats, as trials too."


def conditions(until: Until) -> str:
    """What the end conditions of a phase ask for, in words."""
    said = []
    if until.force_residual is not None:
        said.append(f"‖ρ_f‖ < {until.force_residual:g}")
    if until.moment_residual is not None:
        said.append(f"‖ρ_m‖ < {1000 * until.moment_residual:g} mm")
    if until.force_error is not None:
        said.append(f"forces ± {until.force_error:g} N")
    said.append("all touching")
    return f"{', '.join(said)}, for {until.hold:g} s"
