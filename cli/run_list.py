"""The runs in a folder, on a terminal or as a document."""

from __future__ import annotations

from pathlib import Path

from graspdsl.cli.messages import result, result_json, say
from graspdsl.cli.tables import laid_out, text_of
from graspdsl.diagnostics import on_one_line
from graspdsl.report.run_list import listed_runs, runs_table
from graspdsl.report.summary import plain


def show_runs(folder: Path, as_json: bool) -> None:
    """Print the runs that are in a folder. Raises DiagnosticError where it cannot be read."""
    found = listed_runs(folder)
    if as_json:
        result_json({"folder": str(folder), "runs": plain(found)})
    elif found:
        result(text_of([laid_out(runs_table(found, f"Runs in {folder}"))]))
    else:
        say(on_one_line(f"there are no runs in {folder}"))
