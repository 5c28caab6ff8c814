"""What is known of a run, as files for other programs."""

from __future__ import annotations

from pathlib import Path

from graspdsl.api.runs import Run
from graspdsl.cli.messages import result, say
from graspdsl.cli.running import opened, opened_either
from graspdsl.diagnostics import Diagnostic, DiagnosticError, listed, on_one_line
from graspdsl.report.data_files import CSV, TEXTS, as_csv, as_jsonl, format_of
from graspdsl.report.exports import ALL
from graspdsl.report.wording import counted

STDOUT = Path("-")


def export_run(
    path: Path, to: Path, what: str, trial: int | None, form: str | None, *, allow_code: bool = False
) -> None:
    """Write a table of a run, all of them, or a trial's trajectory, into files or to stdout. Raises DiagnosticError as
    :meth:`graspdsl.Run.export`."""
    form = format_of(to, (form or CSV) if to == STDOUT or what == ALL else form)
    if to == STDOUT and (form not in TEXTS or what == ALL):
        message, hint = (
            ("all tables are files of a folder", "name the folder with --to")
            if what == ALL
            else (f"{form} is no text for stdout", f"name a file with --to, or give --format {listed(TEXTS, 'or')}")
        )
        raise DiagnosticError([Diagnostic("unknown-format", message, hint=hint)], str(to))
    run = opened(path, allow_code=allow_code) if trial is not None else opened_either(path, allow_code=allow_code)
    if to == STDOUT:
        columns = run.columns_for(what, trial) if isinstance(run, Run) else run.columns_for(what)
        result((as_csv if form == CSV else as_jsonl)(columns).removesuffix("\n"))
        return
    try:
        if isinstance(run, Run):
            run.export(to, what, trial=trial, form=form)
        else:
            run.export(to, what, form=form)
    except ImportError as error:
        message, _, hint = str(error).partition(": ")
        raise DiagnosticError([Diagnostic("not-installed", message, hint=f"install it: {hint}")], str(to)) from None
    said = counted(len(run.tables), "table", "tables") if what == ALL else what
    say(on_one_line(f"{said} → {to}"))
