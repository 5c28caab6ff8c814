"""What of a run is whole, said on a terminal or as a document, and what was mended."""

from __future__ import annotations

from pathlib import Path

from graspdsl.cli.messages import WRONG_INPUT, result, result_json, say
from graspdsl.cli.tables import laid_out, text_of
from graspdsl.diagnostics import on_one_line, reading
from graspdsl.report.summary import plain
from graspdsl.report.tables import Column, Table, trials_named
from graspdsl.trials.health import Finding, Health, examined, mended
from graspdsl.trials.store import RunFolder


def show_health(path: Path, as_json: bool, *, repair: bool, allow_code: bool = False) -> int:
    """Print what of a run is whole, once it is mended if that is asked for. Returns the exit code."""
    with reading(str(path)):
        folder = RunFolder.at(path, allow_code=allow_code)
        done = mended(folder) if repair else []
        health = examined(folder)
    if as_json:
        found = plain(health.findings)
        result_json({"run": str(path), "sound": health.sound, "findings": found, "mended": done})
    else:
        for what in done:
            say(on_one_line(f"mended: {what}"))
        result(text_of([laid_out(_table(health, str(path)))]))
    return 0 if health.sound else WRONG_INPUT


def _table(health: Health, title: str) -> Table:
    columns = (Column("part"), Column("is"), Column("what was found"), Column("mended by"))
    rows = tuple((found.part, found.verdict.value, _said(found), found.mended_by) for found in health.findings)
    return Table(title, columns, rows)


def _said(found: Finding) -> str:
    return f"{found.says} (trial {trials_named(found.trials)})" if found.trials else found.says
