"""Runs side by side on a terminal, and the files of a comparison."""

from __future__ import annotations

from pathlib import Path

from rich.console import RenderableType
from rich.text import Text

from graspdsl.cli.messages import result, result_json, say, writable
from graspdsl.cli.running import RUNS, opened
from graspdsl.cli.tables import laid_out, text_of
from graspdsl.diagnostics import on_one_line, reading
from graspdsl.report.comparison import Comparison, comparison, comparison_tables, methods_of
from graspdsl.report.comparison_page import PAGE, write_comparison
from graspdsl.report.sameness import said_of
from graspdsl.report.summary import plain
from graspdsl.trials.folders import fresh_folder


def show_comparison(paths: list[Path], out: Path | None, as_json: bool, *, allow_code: bool = False) -> None:
    """Print a comparison of the runs in these folders, and write its figures and its page."""
    runs = [opened(path, allow_code=allow_code) for path in paths]
    found = comparison([(run.evidence, run.summary) for run in runs])
    with reading(str(out or RUNS)):
        place = out or fresh_folder(RUNS, "compare")
        write_comparison(place, [run.evidence for run in runs], found)
    if as_json:
        result_json({**plain(found), "folder": str(place)})
    else:
        result(comparison_text(found))
    say(f"report: {on_one_line(str(place / PAGE))}")


def comparison_text(found: Comparison) -> str:
    """A comparison laid out for the terminal that stdout is."""
    heads = [
        ", ".join([f"{number}: {run.summary.name}", *run.settings, f"seed {run.summary.seed}", run.summary.run])
        for number, run in enumerate(found.runs, 1)
    ]
    parts: list[RenderableType] = [Text(writable(on_one_line(head)), overflow="fold") for head in heads]
    parts += [part for said in said_of(found.sameness) for part in ("", Text(writable(said)))]
    parts += [part for made in comparison_tables(found) for part in ("", laid_out(made))]
    return text_of([*parts, "", *[Text(method) for method in methods_of(found)]])
