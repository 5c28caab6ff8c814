"""Tables and the summary of a run on a terminal."""

from __future__ import annotations

import io
import sys
from collections.abc import Iterable
from dataclasses import dataclass
from typing import TYPE_CHECKING

import rich.table
from rich.box import SIMPLE_HEAD
from rich.console import Console, ConsoleOptions, RenderableType, RenderResult
from rich.segment import Segment
from rich.text import Text

from graspdsl.cli.messages import printable, writable
from graspdsl.diagnostics import on_one_line
from graspdsl.report.tables import Table
from graspdsl.report.wording import conditions, feasible, number, percent, percents, repetition

if TYPE_CHECKING:
    from graspdsl.report.summary import Summary


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


def laid_out(made: Table) -> rich.table.Table:
    """A table for a terminal: words to the left, numbers to the right."""
    listed = rich.table.Table(
        title=made.title, title_justify="left", title_style="bold", box=SIMPLE_HEAD, show_edge=False, pad_edge=False
    )
    for column in made.columns:
        to_the_left = column.left or column.format.words
        listed.add_column(
            writable(column.head(with_unit=False)), justify="left" if to_the_left else "right", overflow="fold"
        )
    for row in made.cells(with_units=True):
        listed.add_row(*(writable(on_one_line(cell.text)) for cell in row))
    listed.caption, listed.caption_justify = made.note or None, "left"
    return listed


def summary_text(summary: Summary) -> str:
    """The summary of a run, laid out for the terminal that stdout is."""
    from graspdsl.report.run_tables import brief_tables

    tables = [part for made in brief_tables(summary) for part in ("", laid_out(made))]
    return text_of([*_head(summary), *tables, *_foot(summary)], f"  {summary.command}")


def _head(summary: Summary) -> list[RenderableType]:
    finished, asked = summary.finished, summary.asked
    head: list[RenderableType] = [Text(f"{summary.name}, seed {summary.seed}", style="bold")]
    if finished < asked:
        head.append(f"{finished} of {asked} trials are finished")
    if finished:
        head.append(
            f"{summary.outcomes.get('converged', 0)} of {finished} trials converged: "
            f"{percent(summary.converged)} (95 % interval {percents(summary.converged_interval)})"
        )
    if said := feasible(summary.starts):
        head.append(f"That is {said}.")
    repeated = repetition(summary)
    return [*head, *([repeated] if repeated else []), f"Converged: {conditions(summary.converged_means)}."]


def _foot(summary: Summary) -> list[RenderableType]:
    return [
        "",
        f"Simulated {number(summary.world_s, 's', 0)} in {number(summary.wall_s, 's', 1)}.",
        Text(f"The run is in {on_one_line(summary.run)}; to repeat it:", overflow="fold"),
    ]
