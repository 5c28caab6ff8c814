"""What differs between two runs, on a terminal or as a document."""

from __future__ import annotations

from pathlib import Path

from graspdsl.cli.messages import result, result_json
from graspdsl.cli.tables import laid_out, text_of
from graspdsl.compiler.program import Program
from graspdsl.diagnostics import reading
from graspdsl.report.run_differences import differences, differences_table
from graspdsl.report.summary import plain
from graspdsl.trials.runner import program_of_run
from graspdsl.trials.store import SPEC, RunFolder


def show_differences(paths: tuple[Path, Path], as_json: bool, *, allow_code: bool = False) -> None:
    """Print what differs between the specs, versions, plug-ins and files of two runs. Raises DiagnosticError where one
    of them or its spec cannot be read."""
    first, second = (_read(path, allow_code) for path in paths)
    found, names = differences(first, second), [str(path) for path in paths]
    if as_json:
        result_json({"runs": names, "same": not found, "differences": plain(found)})
    elif found:
        result(text_of([laid_out(differences_table(found, names))]))
    else:
        result("nothing differs: the spec, the seed, versions, plug-ins and files are the same")


def _read(path: Path, allow_code: bool) -> tuple[RunFolder, Program]:
    with reading(str(path)):
        folder = RunFolder.at(path, allow_code=allow_code)
        text = folder.spec_text
    with reading(str(path / SPEC), text):
        return folder, program_of_run(folder)
