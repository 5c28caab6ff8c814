"""What a user gives the commands: read and checked, or refused with the place of every fault."""

from __future__ import annotations

import re
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

import typer

from graspdsl.cli.messages import WRONG_INPUT, as_file_json, complain, result_json
from graspdsl.diagnostics import Diagnostic, DiagnosticError

if TYPE_CHECKING:
    from graspdsl.compiler.program import Program


HAND_FILE = re.compile(r"(?:\s*(?:#[^\n]*)?\n)*hand\s*:")
MOUNT_FILE = re.compile(HAND_FILE.pattern.replace("hand", "mount"))


def named(text: str) -> Path:
    """The file or folder of a name on the command line. An empty one, which would be the working directory, is none."""
    if not text:
        raise typer.BadParameter("the name is empty")
    return Path(text)


def judged(path: Path, *, allow_code: bool = False) -> tuple[str, tuple[Diagnostic, ...]]:
    """The text of a spec, of a hand file or of a mount file, and every complaint about it; the latter two say 'hand:'
    or 'mount:' first of all."""
    from graspdsl.api.programs import examined
    from graspdsl.compiler.program import missing_engine

    source, examination = examined(path, allow_code=allow_code)
    is_mount = MOUNT_FILE.match(source) is not None
    if HAND_FILE.match(source) is None and not is_mount:
        missing = missing_engine(examination.program) if examination.program else None
        return source, (*examination.diagnostics, *([missing] if missing else []))
    from graspdsl.hands.description_files import DescriptionFileError
    from graspdsl.hands.hand_files import hand_in
    from graspdsl.hands.mount_files import mount_in
    from graspdsl.places.files import SpecFolder

    read = mount_in if is_mount else hand_in
    try:
        return source, read(SpecFolder(path.parent), path.name).warnings
    except DescriptionFileError as error:
        return error.text, error.diagnostics
    except DiagnosticError as error:
        return source, error.diagnostics


def sound(path: Path, overrides: tuple[str, ...] = (), *, allow_code: bool = False) -> Program:
    """The program of a spec file, to be run; warnings go to stderr.

    Raises DiagnosticError when it has errors, or what its world needs is not installed.
    """
    from graspdsl.api.programs import examined, program_in
    from graspdsl.compiler.program import missing_engine

    source, examination = examined(path, overrides, allow_code=allow_code)
    program = program_in(examination, str(path), source)
    complain(str(path), source, examination.diagnostics)
    if missing := missing_engine(program):
        raise DiagnosticError([missing], str(path), source)
    return program


@contextmanager
def answering(as_json: bool = False) -> Iterator[None]:
    """What a command does within ends with the right exit code when its input is refused."""
    try:
        try:
            yield
        except BaseException:
            from graspdsl.plugins.answering import answered_for  # which takes its time to import

            with answered_for():
                raise
    except DiagnosticError as error:
        name = error.name or "graspdsl"
        complain(name, error.source, error.diagnostics)
        if as_json:
            result_json({"files": [as_file_json(name, error.diagnostics)]})
        raise typer.Exit(WRONG_INPUT) from None
