"""The summary of a run on a terminal."""

from __future__ import annotations

from typing import Any

from rich.console import Console
from rich.table import Table
from rich.text import Text

from graspdsl.report.statistics import wilson


def show_summary(numbers: dict[str, Any]) -> None:
    """Print the summary of a run on stdout."""
    console = Console(highlight=False, emoji=False, markup=False)
    trials = numbers["trials"]
    console.print(Text(f"{numbers['name']}", style="bold"), f"seed {numbers['seed']}, {numbers['run']}")
    converged, (low, high) = numbers["converged"]["share"], numbers["converged"]["interval"]
    if converged is not None:
        count = numbers["outcomes"].get("converged", 0)
        console.print(
            f"{count} of {trials['finished']} trials converged: {_percent(converged)} "
            f"(95 % interval {_percent(low)} to {_percent(high)}); {trials['asked']} were asked for"
        )
    console.print(_outcomes(numbers), _modes(numbers), _measures(numbers))
    console.print(
        f"{_number(numbers['world_s'], 's', 0)} simulated in {_number(numbers['wall_s'], 's', 1)}; "
        f"{numbers['redraws']} starts redrawn because the hand could not take them up"
    )


def _outcomes(numbers: dict[str, Any]) -> Table:
    table = Table("outcome", "trials", "share", "95 % interval", title="How trials ended", title_justify="left")
    finished = numbers["trials"]["finished"]
    for name, count in numbers["outcomes"].items():
        low, high = wilson(count, finished)
        table.add_row(name, str(count), _percent(count / finished), f"{_percent(low)} to {_percent(high)}")
    return table


def _modes(numbers: dict[str, Any]) -> Table:
    columns = ("mode [rad]", "trials", "share", "95 % interval", "‖ρ_f‖", "‖ρ_m‖ [mm]")
    table = Table(*columns, title="Where grasps ended (orientation, medians by mode)", title_justify="left")
    for mode in numbers["modes"]:
        low, high = mode["interval"]
        table.add_row(
            f"{mode['centre']:.2f}",
            str(len(mode["trials"])),
            _percent(mode["share"]),
            f"{_percent(low)} to {_percent(high)}",
            _number(mode["force_residual"], "", 3),
            _number(_scaled(mode["moment_residual"]), "", 2),
        )
    return table


def _measures(numbers: dict[str, Any]) -> Table:
    table = Table("measure", "start", "end", title="Medians over trials", title_justify="left")
    residuals, orientation = numbers["residuals"], numbers["orientation"]
    force, moment = residuals["force"], residuals["moment"]
    table.add_row("force residual ‖ρ_f‖", _number(force["start"], "", 3), _number(force["end"], "", 3))
    table.add_row(
        "moment residual ‖ρ_m‖", _number(_scaled(moment["start"]), "mm", 1), _number(_scaled(moment["end"]), "mm", 1)
    )
    table.add_row("orientation, range", _range(orientation["start"]), _range(orientation["end"]))
    ticks, pressed = numbers["ticks_to_converge"], numbers["contact_force"]
    table.add_row("ticks to converge", "", f"{_number(ticks['median'], '', 0)} (90 %: {_number(ticks['p90'], '', 0)})")
    table.add_row(
        "contact forces of converged grasps",
        "",
        f"{_number(pressed['least'], '', 2)} … {_number(pressed['largest'], 'N', 2)}",
    )
    shift = numbers["object_shift"]
    table.add_row("object moved", "", f"{_number(_scaled(shift['median']), 'mm', 1)}, at most "
                  f"{_number(_scaled(shift['largest']), 'mm', 1)}")  # fmt: skip
    table.add_row("largest leak between priorities", "", _exponent(numbers["priorities"]["largest_leak"]))
    return table


def _percent(share: float) -> str:
    return f"{100 * share:.0f} %"


def _scaled(metres: float | None) -> float | None:
    return None if metres is None else 1000 * metres


def _number(value: float | None, unit: str, digits: int) -> str:
    return "–" if value is None else f"{value:.{digits}f} {unit}".rstrip()


def _exponent(value: float | None) -> str:
    return "–" if value is None else f"{value:.0e}"


def _range(values: list[float | None]) -> str:
    known = [value for value in values if value is not None]
    return f"{min(known):.2f} … {max(known):.2f} rad" if known else "–"
