"""What a user gives the commands: read and checked, or refused with the place of every fault."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

import typer

from graspdsl.cli.messages import WRONG_INPUT, as_file_json, complain, result_json, say
from graspdsl.diagnostics import Diagnostic, DiagnosticError, listed, nearest
from graspdsl.places.folders import HAND_FILE, MOUNT_FILE, SUFFIXES

if TYPE_CHECKING:
    from graspdsl.compiler.program import Program


def named(text: str) -> Path:
    """The file or folder of a name on the command line. An empty one, which would be the working directory, is none."""
    if not text:
        raise typer.BadParameter("the name is empty")
    return Path(text)


def place_of_shipped(name: str) -> Path | None:
    """Where the spec of a name is that ships with the package; None where there is none, or a file of this name, also
    with a suffix that is left out."""
    if Path(name).suffix in SUFFIXES or os.sep in name or any(map(_is_a_file, (name, *(name + s for s in SUFFIXES)))):
        return None
    from graspdsl.spec.shipped import shipped_specs

    if (spec := shipped_specs().get(name)) is not None:
        return spec.place
    if near := nearest(name, shipped_specs()):
        hint = f"did you mean {listed(near, 'or')}, which ships with the package?"
        raise DiagnosticError([Diagnostic("file-not-found", "there is no such file", hint=hint)], name)
    return None


def _is_a_file(name: str) -> bool:
    return os.path.lexists(name) and not os.path.isdir(name)


def found(path: Path) -> Path:
    """The file of this name; where there is none, the spec of this name that ships."""
    shipped = place_of_shipped(str(path))
    if shipped is None:
        return path
    say(f"{path} is a spec that ships; for a copy to change: graspdsl init --from {path}")
    return shipped


def judged(path: Path, *, allow_code: bool = False) -> tuple[str, tuple[Diagnostic, ...]]:
    """The text of a spec, of a hand file or of a mount file, and every complaint about it; the latter two say 'hand:'
    or 'mount:' first of all."""
    from graspdsl.api.programs import examined
    from graspdsl.compiler.program import missing_engine

    path = found(path)
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


def sound(path: Path, overrides: tuple[str, ...] = (), *, allow_code: bool = False, sweeps: bool = False) -> Program:
    """The program of a spec file, to be run; warnings go to stderr.

    Raises DiagnosticError when it has errors, or what its world needs is not installed, or for a sweep where none can
    be.
    """
    from graspdsl.api.programs import examined, program_in
    from graspdsl.compiler.program import missing_engine

    path = found(path)
    source, examination = examined(path, overrides, allow_code=allow_code)
    program = program_in(examination, str(path), source)
    complain(str(path), source, examination.diagnostics)
    if missing := missing_engine(program):
        raise DiagnosticError([missing], str(path), source)
    if program.points and not sweeps:
        message = f"this spec is a sweep of {len(program.points)} points, which 'graspdsl run' runs"
        hint = "leave it out: --set sweep=null"
        raise DiagnosticError([Diagnostic("is-a-sweep", message, hint=hint)], str(path), source)
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
