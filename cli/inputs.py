"""What a user gives the commands: read and checked, or refused with the place of every fault."""

from __future__ import annotations

import re
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

import typer

from graspdsl.cli.messages import WRONG_INPUT, as_file_json, complain, result_json
from graspdsl.diagnostics import Diagnostic, DiagnosticError, has_errors

if TYPE_CHECKING:
    from graspdsl.compiler.program import Program


HAND_FILE = re.compile(r"(?:\s*(?:#[^\n]*)?\n)*hand\s*:")


def named(text: str) -> Path:
    """The file or folder of a name on the command line. An empty one, which would be the working directory, is none."""
    if not text:
        raise typer.BadParameter("the name is empty")
    return Path(text)


def examined(path: Path, overrides: tuple[str, ...] = ()) -> tuple[Program | None, str, tuple[Diagnostic, ...]]:
    """The program of a spec file if it is sound, its text, and every complaint about it."""
    from graspdsl.compiler.program import examine
    from graspdsl.places.files import folder_of_files, read_text

    try:
        source = read_text(path)
    except DiagnosticError as error:
        return None, "", error.diagnostics
    examination = examine(source, path.name, overrides, folder_of_files(path))
    return examination.program, source, examination.diagnostics


def judged(path: Path) -> tuple[str, tuple[Diagnostic, ...]]:
    """The text of a spec or of a hand file, and every complaint about it; a hand file says 'hand:' first of all."""
    _, source, diagnostics = examined(path)
    if HAND_FILE.match(source) is None:
        return source, diagnostics
    from graspdsl.hands.hand_files import HandFileError, hand_in
    from graspdsl.places.files import SpecFolder

    try:
        return source, hand_in(SpecFolder(path.parent), path.name).warnings
    except HandFileError as error:
        return error.text, error.diagnostics
    except DiagnosticError as error:
        return source, error.diagnostics


def sound(path: Path, overrides: tuple[str, ...] = ()) -> Program:
    """The program of a spec file; warnings go to stderr. Raises DiagnosticError when it has errors."""
    program, source, diagnostics = examined(path, overrides)
    if program is None or has_errors(diagnostics):
        raise DiagnosticError(diagnostics, str(path), source)
    complain(str(path), source, diagnostics)
    return program


@contextmanager
def answering(as_json: bool = False) -> Iterator[None]:
    """What a command does within ends with the right exit code when its input is refused."""
    try:
        yield
    except DiagnosticError as error:
        name = error.name or "graspdsl"
        complain(name, error.source, error.diagnostics)
        if as_json:
            result_json({"files": [as_file_json(name, error.diagnostics)]})
        raise typer.Exit(WRONG_INPUT) from None
