"""What files to begin with have in common: their names, and how they name the model that they are guessed from."""

from __future__ import annotations

import os
from pathlib import Path

from graspdsl.diagnostics import Diagnostic, DiagnosticError
from graspdsl.models.model import Model
from graspdsl.models.reading import read_model
from graspdsl.places.files import SpecFolder
from graspdsl.places.folders import SUFFIXES


def refuse_place(example: str, place: Path, *beside: Path) -> None:
    """Raises DiagnosticError for a name by which no spec finds a hand or mount file, and where there is a file already,
    there or at a place beside it."""
    _refuse_name(place, f"name another file: --out {example}")
    for each in (place, *beside):
        if os.path.lexists(each):
            hint = f"name another file: --out {example}"
            raise DiagnosticError([Diagnostic("file-exists", "this file is there already", hint=hint)], str(each))


def refuse_spec(example: str, place: Path, *, force: bool) -> None:
    """Raises DiagnosticError for a name that is none of a spec, and where there is a file already, unless by force."""
    _refuse_name(place, f"for example: graspdsl init {example}")
    if place.is_dir():
        hint = f"name a file, for example: graspdsl init {example}"
        raise DiagnosticError([Diagnostic("is-a-directory", "this is a directory, not a file", hint=hint)], str(place))
    if os.path.lexists(place) and not force:
        hint = f"name another file, graspdsl init {example}, or write over it: --force"
        raise DiagnosticError([Diagnostic("file-exists", "this file is there already", hint=hint)], str(place))


def _refuse_name(place: Path, hint: str) -> None:
    if place.suffix not in SUFFIXES:
        message = "the name of a spec, a hand file or a mount file ends in .yaml"
        raise DiagnosticError([Diagnostic("unknown-suffix", message, hint=hint)], str(place))


def found_model(model: Path, place: Path, root: str) -> tuple[str, Model]:
    """How a file at a place names a model, and the model: by where it is below the file's folder, where that can be and
    it names no files elsewhere, else by its absolute path."""
    whole, files = Path(os.path.realpath(model)), SpecFolder(place.parent)
    folder = Path(os.path.realpath(place.parent))
    if whole.is_relative_to(folder):
        below = whole.relative_to(folder).as_posix()
        try:
            return below, read_model(files, below, root)
        except DiagnosticError as error:
            if any(fault.code != "outside-of-folder" for fault in error.diagnostics):
                raise
    return str(whole), read_model(files, str(whole), root)
