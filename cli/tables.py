"""The summary of a run on a terminal."""

from __future__ import annotations

import io
import sys
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from typing import Any

from rich.box import SIMPLE_HEAD
from rich.console import Console, ConsoleOptions, RenderableType, RenderResult
from rich.segment import Segment
from rich.table import Table
from rich.text import Text

from graspdsl.cli.messages import printable, writable
from graspdsl.diagnostics import on_one_line
from graspdsl.report.statistics import wilson
from graspdsl.report.wording import conditions, counted, feasible, millimetres, number, percent, quantiles, repetition

Numbers = dict[str, Any]


def summary_text(numbers: Numbers) -> str:
    """The summary of a run, laid out for the terminal that stdout is."""
    tables = [part for made in _tables(numbers) for part in ("", made(numbers))]
    return text_of([*_head(numbers), *tables, *_foot(numbers)], f"  {numbers['command']}")


def _tables(numbers: Numbers) -> list[Callable[[Numbers], Table]]:
    reasons = [_reasons] if any(_unconverged(numbers)) else []
    starts = numbers["starts"]
    selected = [_rejected, *([_starts] if starts["parameters"] else [])] if starts["rejected"] else []
    return [_outcomes, *reasons, *selected, _modes, _measures, *([_quality] if numbers["quality"] else [])]


def text_of(parts: Iterable[RenderableType], unwrapped: str = "") -> str:
    """Lines and tables laid out for the terminal that stdout is; then a line that must stay in one, to be copied."""
    text = io.StringIO()
    console = Console(file=text, force_terminal=sys.stdout.isatty(), highlight=False, emoji=False, markup=False)
    for part in parts:
        console.print(_Printable(part))
    if unwrapped:
        console.print(Text(on_one_line(unwrapped)), soft_wrap=True)
    return text.getvalue().rstrip("\n")


@dataclass(frozen=True, slots=True)
class _Printable:
    """What is laid out, with the control characters of names and messages replaced; styles are rich's own."""

    part: RenderableType

    def __rich_console__(self, console: Console, options: ConsoleOptions) -> RenderResult:
        shown = console.render_str(self.part) if isinstance(self.part, str) else self.part
        for segment in console.render(shown, options):
            yield Segment(printable(segment.text), segment.style, segment.control)


def _head(numbers: Numbers) -> list[RenderableType]:
    finished, asked = numbers["trials"]["finished"], numbers["trials"]["asked"]
    head: list[RenderableType] = [Text(f"{numbers['name']}, seed {numbers['seed']}", style="bold")]
    if finished < asked:
        head.append(f"{finished} of {asked} trials are finished")
    if finished:
        low, high = numbers["converged"]["interval"]
        head.append(
            f"{numbers['outcomes'].get('converged', 0)} of {finished} trials converged: "
            f"{percent(numbers['converged']['share'])} (95 % interval {percent(low)} to {percent(high)})"
        )
    if said := feasible(numbers["starts"]):
        head.append(f"That is {said}.")
    repeated = repetition(numbers["trials"])
    return [*head, *([repeated] if repeated else []), f"Converged: {conditions(numbers['converged']['means'])}."]


def table(title: str, *columns: str, words: bool = False) -> Table:
    """A table for a terminal: the first column to the left, numbers to the right; with ``words``, all to the left."""
    made = Table(
        title=title, title_justify="left", title_style="bold", box=SIMPLE_HEAD, show_edge=False, pad_edge=False
    )
    for place, column in enumerate(columns):
        made.add_column(writable(column), justify="left" if words or place == 0 else "right", overflow="fold")
    return made


def row(to: Table, *cells: str) -> None:
    """Add a row of texts to a table."""
    to.add_row(*(writable(on_one_line(cell)) for cell in cells))


def _outcomes(numbers: Numbers) -> Table:
    listed = table("How trials ended", "outcome", "trials", "share", "95 % interval")
    finished = numbers["trials"]["finished"]
    for name, count in numbers["outcomes"].items():
        low, high = wilson(count, finished)
        row(listed, name, str(count), percent(count / finished), f"{percent(low)} to {percent(high)}")
    return listed


def _reasons(numbers: Numbers) -> Table:
    return reasons_table(
        "Why trials did not converge, mostly",
        (
            (entry["outcome"], said["detail"], len(said["trials"]), entry["count"])
            for entry, said in _unconverged(numbers)
        ),
    )


def _unconverged(numbers: Numbers) -> Iterator[tuple[Numbers, Numbers]]:
    """The outcomes but convergence of which something was said, each with what was said most often."""
    for entry in numbers["outcome_table"]:
        if entry["outcome"] != "converged" and entry["details"]:
            yield entry, entry["details"][0]


def reasons_table(title: str, reasons: Iterable[tuple[str, str, int, int]]) -> Table:
    """Outcomes, each with what was said most often, of how many, and how many there are."""
    listed = table(title, "outcome", "what was said", words=True)
    for outcome, said, count, whole in reasons:
        row(listed, outcome, said if count == whole else f"{said} ({count} of {whole})")
    return listed


def _rejected(numbers: Numbers) -> Table:
    listed = table("Why draws of a start could not be taken up", "reason", "draws", "share")
    for reason, count in numbers["starts"]["rejected"].items():
        row(listed, reason, str(count), percent(count / numbers["starts"]["draws"]))
    return listed


def _starts(numbers: Numbers) -> Table:
    listed = table("Starts, asked for and kept: 5 %, 50 % and 95 % quantiles", "", "asked", "kept")
    for name, found in numbers["starts"]["parameters"].items():
        row(listed, name, quantiles(found["asked"], found["unit"]), quantiles(found["kept"], found["unit"]))
    return listed


def _modes(numbers: Numbers) -> Table:
    columns = ("orientation", "trials", "share", "95 % interval", "‖ρ_f‖", "‖ρ_m‖")
    listed = table("Where grasps ended: modes of orientation, with medians", *columns)
    for mode in numbers["modes"]:
        low, high = mode["interval"]
        row(
            listed,
            f"{mode['centre']:.2f} rad",
            str(len(mode["trials"])),
            percent(mode["share"]),
            f"{percent(low)} to {percent(high)}",
            number(mode["force_residual"], "", 3),
            millimetres(mode["moment_residual"]),
        )
    base = numbers["modes"][0]["of"] if numbers["modes"] else numbers["in_contact"]["end"].count(True)
    whole = counted(base, "trial", "trials")
    listed.caption, listed.caption_justify = f"of {whole} whose contacts all touched at the end", "left"
    return listed


def _measures(numbers: Numbers) -> Table:
    listed = table("What was measured: medians over trials", "", "start", "end")
    residuals, orientation = numbers["residuals"], numbers["orientation"]
    force, moment = residuals["force"], residuals["moment"]
    ticks, pressed, shift = numbers["ticks_to_converge"], numbers["contact_force"], numbers["object_shift"]
    row(listed, "force residual ‖ρ_f‖", number(force["start"], "", 3), number(force["end"], "", 3))
    row(listed, "moment residual ‖ρ_m‖", millimetres(moment["start"]), millimetres(moment["end"]))
    row(listed, "orientation, range", _range(orientation["start"]), _range(orientation["end"]))
    row(listed, "contact force, range *", "", _span(pressed["least"], pressed["largest"], "N"))
    row(listed, "object moved", "", millimetres(shift["median"]))
    row(listed, "  at most", "", millimetres(shift["largest"]))
    row(listed, "ticks or probes to converge *", "", number(ticks["median"], "", 0))
    row(listed, "  9 in 10 within", "", number(ticks["p90"], "", 0))
    row(listed, "tactile samples *", "", number(numbers["samples"]["median"], "", 0))
    if numbers["probes"]["total"]:
        row(listed, "probes, all trials", "", number(numbers["probes"]["total"], "", 0))
    row(listed, "time of a trial *", "", number(numbers["trial_s"]["median"], "s", 1))
    row(listed, "largest leak of a lower priority", "", _exponent(numbers["priorities"]["largest_leak"]))
    listed.caption, listed.caption_justify = "* of converged trials", "left"
    return listed


def _quality(numbers: Numbers) -> Table:
    """The grades that were asked for, then by outcome."""
    grades = numbers["quality"]
    shares = {"force closure": "force_closure", "kept when lifted": "lift", "kept when shaken": "shake"}
    asked = {title: name for title, name in shares.items() if name in grades}
    listed = table("How good the grasps are, by outcome", "", *asked)
    for outcome, counts in grades["confusion"]["outcomes"].items():
        row(listed, outcome, *(f"{counts[name]} of {counts['trials']}" for name in asked.values()))
    said = [f"{percent(grades[name]['share'])}{_within(grades[name]['interval'])}" for name in asked.values()]
    row(listed, "all, 95 % interval", *said)
    if "ferrari_canny" in grades:
        epsilon, volume = (grades["ferrari_canny"][name]["median"] for name in ("epsilon", "volume"))
        listed.caption = f"Ferrari-Canny, medians: ε {_significant(epsilon)}, volume {_significant(volume)}"
        listed.caption_justify = "left"
    return listed


def _significant(value: float | None) -> str:
    return "–" if value is None else f"{value:.2g}"


def _within(interval: tuple[float, float]) -> str:
    return f" ({percent(interval[0])} to {percent(interval[1])})"


def _foot(numbers: Numbers) -> list[RenderableType]:
    return [
        "",
        f"Simulated {number(numbers['world_s'], 's', 0)} in {number(numbers['wall_s'], 's', 1)}.",
        Text(f"The run is in {on_one_line(numbers['run'])}; to repeat it:", overflow="fold"),
    ]


def _exponent(value: float | None) -> str:
    return "–" if value is None else f"{value:.0e}"


def _range(values: list[float | None]) -> str:
    known = [value for value in values if value is not None]
    return _span(min(known), max(known), "rad") if known else "–"


def _span(low: float | None, high: float | None, unit: str) -> str:
    return "–" if low is None or high is None else f"{low:.2f} … {high:.2f} {unit}"
