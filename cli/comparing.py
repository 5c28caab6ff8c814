"""Runs side by side on a terminal, and the files of a comparison."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from rich.console import RenderableType
from rich.text import Text

from graspdsl.cli.inputs import reading
from graspdsl.cli.messages import result, result_json, say, writable
from graspdsl.cli.running import RUNS, opened
from graspdsl.cli.tables import row, table, text_of
from graspdsl.diagnostics import on_one_line
from graspdsl.report.comparison import comparison
from graspdsl.report.comparison_page import PAGE, write_comparison
from graspdsl.report.comparison_tables import methods_of, tables_of
from graspdsl.trials.store import fresh_folder


def show_comparison(paths: list[Path], out: Path | None, as_json: bool) -> None:
    """Print a comparison of the runs in these folders, and write its figures and its page."""
    folders = [opened(path) for path in paths]
    numbers = comparison(folders)
    with reading(str(out or RUNS)):
        place = out or fresh_folder(RUNS, "compare")
        write_comparison(place, folders, numbers)
    if as_json:
        result_json({**numbers, "folder": str(place)})
    else:
        result(comparison_text(numbers))
    say(f"report: {on_one_line(str(place / PAGE))}")


def comparison_text(numbers: dict[str, Any]) -> str:
    """A comparison laid out for the terminal that stdout is."""
    heads = [
        ", ".join([f"{number}: {run['name']}", *run["settings"], f"seed {run['seed']}", run["run"]])
        for number, run in enumerate(numbers["runs"], 1)
    ]
    parts: list[RenderableType] = [Text(writable(on_one_line(head)), overflow="fold") for head in heads]
    for made in tables_of(numbers):
        side = table(made.title, *made.columns)
        for cells in made.rows:
            row(side, *cells)
        side.caption, side.caption_justify = made.note or None, "left"
        parts += ["", side]
    return text_of([*parts, "", *[Text(method) for method in methods_of(numbers)]])
