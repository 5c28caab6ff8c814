"""Specs, read and checked."""

from __future__ import annotations

import inspect
import warnings
from collections.abc import Iterable, Sequence
from os import PathLike
from pathlib import Path

from graspdsl.compiler.program import Examination, Program, examine
from graspdsl.diagnostics import Diagnostic, DiagnosticError, as_text
from graspdsl.places.files import folder_of_files, read_text


class SpecWarning(UserWarning):
    """A warning about a spec or a run, as the command line prints it."""


def load(path: str | PathLike[str], *, set: Sequence[str] = (), allow_code: bool = False) -> Program:
    """The program of a spec file, checked.

    set: values in place of those in the file, ``["scene.friction=0.6"]``, as ``--set`` takes them. allow_code: whether
    Python files that it names under ``code`` may be run.

    Raises DiagnosticError, whose text is what the command line prints, with the place of every mistake at once.
    Warnings come as :class:`SpecWarning`.
    """
    text, examination = examined(Path(path), _settings(set), allow_code=allow_code)
    return _warned(examination, str(path), text)


def loads(
    text: str,
    *,
    set: Sequence[str] = (),
    name: str = "spec.yaml",
    folder: str | PathLike[str] = ".",
    allow_code: bool = False,
) -> Program:
    """The program of the text of a spec, as :func:`load` of a file called ``name`` in a ``folder``, where the files are
    that the spec names by relative paths."""
    return _warned(examine(text, name, _settings(set), Path(folder), allow_code), name, text)


def examined(path: Path, overrides: tuple[str, ...] = (), *, allow_code: bool = False) -> tuple[str, Examination]:
    """The text of a spec file, as far as it can be read, and what became of it."""
    try:
        text = read_text(path)
    except DiagnosticError as error:
        return "", Examination(None, error.diagnostics)
    return text, examine(text, path.name, overrides, folder_of_files(path), allow_code)


def program_in(examination: Examination, name: str, text: str) -> Program:
    """The program of an examined text. Raises DiagnosticError where there is none."""
    if examination.program is None:
        raise DiagnosticError(examination.diagnostics, name, text)
    return examination.program


def with_trials(program: Program, count: int | None, seed: int | None) -> Program:
    """The program of the same source with another number of trials and another seed. Raises DiagnosticError."""
    more = trial_settings(count, seed)
    return with_settings(program, *more) if more else program


def trial_settings(count: int | None, seed: int | None) -> list[str]:
    """The settings of so many trials from a seed, of what is given."""
    asked = {"trials.count": count, "trials.seed": seed}
    return [f"{path}={value}" for path, value in asked.items() if value is not None]


def with_settings(program: Program, *settings: str) -> Program:
    """The program of the same source with other values, as ``--set`` takes them. Raises DiagnosticError."""
    source = program.source._replace(overrides=(*program.source.overrides, *settings))
    return program_in(examine(*source), source.name, source.text)


def warn(name: str, diagnostics: Iterable[Diagnostic], text: str = "") -> None:
    """Warn of what was found in an input of this name, at the line outside of graspdsl that asked for it."""
    level, frame = 1, inspect.currentframe()
    while frame is not None and frame.f_globals.get("__name__", "").partition(".")[0] == "graspdsl":
        level, frame = level + 1, frame.f_back
    for diagnostic in diagnostics:
        warnings.warn(as_text(diagnostic, name, text), SpecWarning, stacklevel=level)


def _settings(given: Sequence[str]) -> tuple[str, ...]:
    return (given,) if isinstance(given, str) else tuple(given)


def _warned(examination: Examination, name: str, text: str) -> Program:
    program = program_in(examination, name, text)
    warn(name, examination.diagnostics, text)
    return program
