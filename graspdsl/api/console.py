"""A run on a terminal: its headline and its tables, as rich lays them out."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING

import rich.table
from rich.box import SIMPLE_HEAD
from rich.console import Group, RenderableType
from rich.text import Text

from graspdsl.diagnostics import on_one_line
from graspdsl.report.tables import Table
from graspdsl.report.wording import conditions, feasible, number, percent, percents, repetition

if TYPE_CHECKING:
    from graspdsl.report.summary import Summary

Spelling = Callable[[str], str]  # of text for whoever cannot write every character


def summary_parts(summary: Summary, spelt: Spelling = str) -> Iterator[RenderableType]:
    """The headline, the tables and the foot of a run's summary."""
    from graspdsl.report.run_tables import brief_tables  # which knows of runs; other tables are laid out here, too

    yield from _head(summary)
    for made in brief_tables(summary):
        yield Text()
        yield laid_out(made, spelt)
    for fact in summary.known:
        yield Text()
        yield Text(spelt(f"Known beforehand: {fact}."), overflow="fold")
    yield Text()
    yield Text(f"Simulated {number(summary.world_s, 's', 0)} in {number(summary.wall_s, 's', 1)}.")
    yield Text(f"The run is in {on_one_line(summary.run)}; to repeat it:", overflow="fold")


def shown(summary: Summary) -> Iterator[RenderableType]:
    """All of it, for a console of somebody else's."""
    yield from summary_parts(summary)
    yield Text(on_one_line(f"  {summary.command}"), overflow="fold")


def laid_out(made: Table, spelt: Spelling = str) -> Group:
    """A table for a terminal: words to the left, numbers to the right, title and note as wide as the terminal."""
    listed = rich.table.Table(box=SIMPLE_HEAD, show_edge=False, pad_edge=False)
    for column in made.columns:
        to_the_left = column.left or column.format.words
        listed.add_column(
            Text(spelt(column.head(with_unit=False))), justify="left" if to_the_left else "right", overflow="fold"
        )
    for row in made.cells(with_units=True):
        listed.add_row(*(Text(spelt(on_one_line(cell.text))) for cell in row))
    title, note = Text(spelt(made.title), "bold"), Text(spelt(made.note), "table.caption")
    return Group(title, listed, *([note] if made.note else []))


def _head(summary: Summary) -> Iterator[RenderableType]:
    finished, asked, converged = summary.finished, summary.asked, summary.converged
    yield Text(on_one_line(f"{summary.name}, seed {summary.seed}"), style="bold")
    if finished < asked:
        yield Text(f"{finished} of {asked} trials are finished")
    if finished:
        share = f"{percent(converged.share)} (95 % interval {percents(converged.interval)})"
        yield Text(f"{summary.outcomes.get('converged', 0)} of {finished} trials converged: {share}")
    if said := feasible(summary.starts):
        yield Text(f"That is {said}.")
    if repeated := repetition(summary.finished, summary.different):
        yield Text(repeated)
    yield Text(f"Converged: {conditions(converged.means)}.")
