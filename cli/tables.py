"""The summary of a run on a terminal."""

from __future__ import annotations

import io
import sys
from typing import Any

from graspdsl.cli.messages import printable, writable
from rich.box import SIMPLE_HEAD
from rich.console import Console, RenderableType
from rich.table import Table
from rich.text import Text

from graspdsl.report.statistics import wilson

Numbers = dict[str, Any]


def summary_text(numbers: Numbers) -> str:
    """The summary of a run, laid out for the terminal that stdout is."""
    text = io.StringIO()
    console = Console(file=text, force_terminal=sys.stdout.isatty(), highlight=False, emoji=False, markup=False)
    for line in _head(numbers):
        console.print(line)
    for table in (_outcomes(numbers), _modes(numbers), _measures(numbers)):
        console.print("", table, sep="\n")
    for line in _foot(numbers):
        console.print(line)
    console.print(Text(f"  {printable(numbers['command'])}"), soft_wrap=True)  # in one line, to be copied
    return text.getvalue().rstrip("\n")


def _head(numbers: Numbers) -> list[RenderableType]:
    finished, asked = numbers["trials"]["finished"], numbers["trials"]["asked"]
    head: list[RenderableType] = [Text(f"{numbers['name']}, seed {numbers['seed']}", style="bold")]
    if finished < asked:
        head.append(f"{finished} of {asked} trials are finished")
    if finished:
        low, high = numbers["converged"]["interval"]
        head.append(
            f"{numbers['outcomes'].get('converged', 0)} of {finished} trials converged: "
            f"{_percent(numbers['converged']['share'])} (95 % interval {_percent(low)} to {_percent(high)})"
        )
    return [*head, f"Converged means: {_conditions(numbers['converged']['means'])}."]


def _conditions(means: Numbers) -> str:
    said = []
    if means["force_residual"] is not None:
        said.append(f"‖ρ_f‖ < {means['force_residual']:g}")
    if means["moment_residual"] is not None:
        said.append(f"‖ρ_m‖ < {1000 * means['moment_residual']:g} mm")
    said.append("every contact touching")
    return f"{', '.join(said)}, for {means['hold']:g} s"


def _table(title: str, *columns: str) -> Table:
    table = Table(
        title=title, title_justify="left", title_style="bold", box=SIMPLE_HEAD, show_edge=False, pad_edge=False
    )
    for place, column in enumerate(columns):
        table.add_column(writable(column), justify="left" if place == 0 else "right", overflow="fold")
    return table


def _row(table: Table, *cells: str) -> None:
    table.add_row(*map(writable, cells))


def _outcomes(numbers: Numbers) -> Table:
    table = _table("How trials ended", "outcome", "trials", "share", "95 % interval")
    finished = numbers["trials"]["finished"]
    for name, count in numbers["outcomes"].items():
        low, high = wilson(count, finished)
        _row(table, name, str(count), _percent(count / finished), f"{_percent(low)} to {_percent(high)}")
    return table


def _modes(numbers: Numbers) -> Table:
    columns = ("orientation", "trials", "share", "95 % interval", "‖ρ_f‖", "‖ρ_m‖")
    table = _table("Where grasps ended: modes of orientation, with medians", *columns)
    for mode in numbers["modes"]:
        low, high = mode["interval"]
        _row(
            table,
            f"{mode['centre']:.2f} rad",
            str(len(mode["trials"])),
            _percent(mode["share"]),
            f"{_percent(low)} to {_percent(high)}",
            _number(mode["force_residual"], "", 3),
            _millimetres(mode["moment_residual"]),
        )
    return table


def _measures(numbers: Numbers) -> Table:
    table = _table("What was measured: medians over trials", "", "start", "end")
    residuals, orientation = numbers["residuals"], numbers["orientation"]
    force, moment = residuals["force"], residuals["moment"]
    ticks, pressed, shift = numbers["ticks_to_converge"], numbers["contact_force"], numbers["object_shift"]
    _row(table, "force residual ‖ρ_f‖", _number(force["start"], "", 3), _number(force["end"], "", 3))
    _row(table, "moment residual ‖ρ_m‖", _millimetres(moment["start"]), _millimetres(moment["end"]))
    _row(table, "orientation, range", _range(orientation["start"]), _range(orientation["end"]))
    _row(table, "contact force, range *", "", _span(pressed["least"], pressed["largest"], "N"))
    _row(table, "object moved", "", _millimetres(shift["median"]))
    _row(table, "  at most", "", _millimetres(shift["largest"]))
    _row(table, "ticks to converge *", "", _number(ticks["median"], "", 0))
    _row(table, "  9 in 10 within", "", _number(ticks["p90"], "", 0))
    _row(table, "largest leak of a lower priority", "", _exponent(numbers["priorities"]["largest_leak"]))
    table.caption, table.caption_justify = "* of converged trials", "left"
    return table


def _foot(numbers: Numbers) -> list[RenderableType]:
    redrawn = numbers["redraws"]
    return [
        "",
        f"Simulated {_number(numbers['world_s'], 's', 0)} in {_number(numbers['wall_s'], 's', 1)}; "
        f"{redrawn} infeasible {'start' if redrawn == 1 else 'starts'} drawn again.",
        Text(f"The run is in {printable(numbers['run'])}; to repeat it:", overflow="fold"),
    ]


def _percent(share: float) -> str:
    return f"{100 * share:.0f} %"


def _number(value: float | None, unit: str, digits: int) -> str:
    return "–" if value is None else f"{value:.{digits}f} {unit}".rstrip()


def _millimetres(metres: float | None) -> str:
    return _number(None if metres is None else 1000 * metres, "mm", 1)


def _exponent(value: float | None) -> str:
    return "–" if value is None else f"{value:.0e}"


def _range(values: list[float | None]) -> str:
    known = [value for value in values if value is not None]
    return _span(min(known), max(known), "rad") if known else "–"


def _span(low: float | None, high: float | None, unit: str) -> str:
    return "–" if low is None or high is None else f"{low:.2f} … {high:.2f} {unit}"
