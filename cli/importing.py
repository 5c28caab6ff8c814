"""Controllers and resources out of a paper: a spec of the definitions in a .tex file."""

from __future__ import annotations

from pathlib import Path

from graspdsl.cli.messages import complain, result, say
from graspdsl.diagnostics import on_one_line, reading
from graspdsl.places.files import read_text


def import_tex(path: Path) -> None:
    """Write the spec of a .tex file's definitions to stdout. Raises DiagnosticError with the faults of all of them."""
    from graspdsl.compiler.importing import spec_of_paper

    with reading(str(path)):
        source = read_text(path)
    with reading(str(path), source):
        text, found, passed_over = spec_of_paper(source, path.name)
    complain(str(path), source, found)
    say(on_one_line(f"{passed_over} other equations and formulas of {path} are passed over"))
    result(text.rstrip("\n"))
