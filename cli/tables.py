"""What is laid out in lines and tables, for the terminal that stdout is."""

from __future__ import annotations

import io
import sys
from collections.abc import Iterable
from dataclasses import dataclass
from typing import TYPE_CHECKING

from rich.console import Console, ConsoleOptions, Group, RenderableType, RenderResult
from rich.segment import Segment
from rich.text import Text

from graspdsl.api import console
from graspdsl.cli.messages import printable, writable
from graspdsl.diagnostics import on_one_line
from graspdsl.report.tables import Table

if TYPE_CHECKING:
    from graspdsl.report.summary import Summary
    from graspdsl.report.sweeps import SweepSummary


def text_of(parts: Iterable[RenderableType], unwrapped: str = "") -> str:
    """Lines and tables laid out for the terminal that stdout is; then a line that must stay in one, to be copied."""
    text = io.StringIO()
    terminal = Console(file=text, force_terminal=sys.stdout.isatty(), highlight=False, emoji=False, markup=False)
    for part in parts:
        terminal.print(_Printable(part))
    if unwrapped:
        terminal.print(Text(on_one_line(unwrapped)), soft_wrap=True)
    return text.getvalue().rstrip("\n")


@dataclass(frozen=True, slots=True)
class _Printable:
    """What is laid out, with the control characters of names and messages replaced; styles are rich's own."""

    part: RenderableType

    def __rich_console__(self, console: Console, options: ConsoleOptions) -> RenderResult:
        shown = console.render_str(self.part) if isinstance(self.part, str) else self.part
        for segment in console.render(shown, options):
            yield Segment(printable(segment.text), segment.style, segment.control)


def laid_out(made: Table) -> Group:
    """A table for a terminal, in the characters that it can write."""
    return console.laid_out(made, writable)


def summary_text(summary: Summary) -> str:
    """The summary of a run, laid out for the terminal that stdout is."""
    return text_of(console.summary_parts(summary, writable), f"  {summary.command}")


def sweep_text(found: SweepSummary) -> str:
    """What a sweep did, laid out for the terminal that stdout is."""
    from graspdsl.report.sweeps import METHODS, changes_tables, correlations_table, points_table, verdict

    tables = [
        points_table(found, briefly=True),
        *changes_tables(found, briefly=True).values(),
        correlations_table(found),
    ]
    parts: list[RenderableType] = [Text(writable(on_one_line(f"{found.name}, seed {found.seed}")), style="bold")]
    parts += [part for table in tables if table.rows for part in ("", laid_out(table))]
    return text_of([*parts, "", Text(writable(verdict(found))), "", Text(writable(METHODS))], f"  {found.command}")
