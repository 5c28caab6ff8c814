"""A file that describes a hand or a mount, and the model that it names."""

from __future__ import annotations

import posixpath
from collections.abc import Callable
from dataclasses import replace
from typing import TypeVar

from graspdsl.diagnostics import Diagnostic, DiagnosticError, in_reading_order
from graspdsl.hands.descriptions import Hand, Mount
from graspdsl.hands.todo import to_dos
from graspdsl.models.model import Model
from graspdsl.models.reading import read_model
from graspdsl.places.document import Document, parse_document
from graspdsl.places.files import SIZE_LIMIT, SpecFolder, refusal, with_plain_line_ends

T = TypeVar("T")


class DescriptionFileError(Exception):
    """A hand or mount file with faults: its name, its text and what is wrong with it, each with its place there."""

    def __init__(self, name: str, text: str, error: DiagnosticError) -> None:
        self.name, self.text, self.diagnostics = name, text, error.diagnostics
        super().__init__(name)


def described_in(files: SpecFolder, name: str, what: str, found: Callable[[SpecFolder, str, Document], T]) -> T:
    """What is ``found`` in a file; ``what``: a hand or a mount.

    Raises DiagnosticError when the file cannot be read, DescriptionFileError with every fault in it.
    """
    content = files.read(name)
    if len(content) > SIZE_LIMIT:
        message = f"{name} is too large: {len(content)} bytes, where a {what} file may have {SIZE_LIMIT}"
        raise refusal("file-too-large", message, "check that this is the file you meant")
    text = with_plain_line_ends(content.decode("utf-8", errors="replace"))
    try:
        document = parse_document(text, name)
        if asked := list(to_dos(document)):
            raise DiagnosticError(in_reading_order(asked))
        return found(files, name, document)
    except DiagnosticError as error:
        raise DescriptionFileError(name, text, error) from None


def model_of(files: SpecFolder, name: str, said: Hand | Mount, document: Document) -> tuple[Model, list[Diagnostic]]:
    """The model that a hand or mount file names, and its warnings at their place in the file.

    Raises DiagnosticError where the file names none or two, or with what is wrong with the model, placed likewise.
    """
    what, root = ("hand", said.root) if isinstance(said, Hand) else ("mount", "")
    if bool(said.urdf) == bool(said.mjcf):
        message, hint = f"a {what} file names one model, a URDF or a MJCF", f"name the model: urdf: my_{what}.urdf"
        raise DiagnosticError([Diagnostic("missing-key", message, document.key_span((what,)), hint)])
    file = said.urdf or said.mjcf
    beside = file if posixpath.isabs(file) else posixpath.join(posixpath.dirname(name), file)
    try:
        model = read_model(files, beside, root)
    except DiagnosticError as error:
        raise DiagnosticError([_placed(fault, document) for fault in error.diagnostics]) from None
    return model, [_placed(warning, document) for warning in model.warnings]


def _placed(diagnostic: Diagnostic, document: Document) -> Diagnostic:
    key = "root" if diagnostic.code == "unknown-root" else "mjcf" if "mjcf" in document.data else "urdf"
    return replace(diagnostic, span=document.span((key,)), fixes=())
