"""Numbers of a file that other readers of YAML take for other numbers."""

from __future__ import annotations

import re
from collections.abc import Iterator

from graspdsl.compiler.complaints import Complaints
from graspdsl.places.document import Document, Path

OCTAL = re.compile(r"([-+]?)0{1,50}([0-7]{1,50})")


def check_numbers(document: Document, complaints: Complaints) -> None:
    """Warn of whole numbers with a leading zero, which YAML 1.1 has for octal ones."""
    for path, text in _written(document):
        found = OCTAL.fullmatch(text)
        decimal, octal = (int(found[1] + found[2], base) for base in (10, 8)) if found else (0, 0)
        if decimal != octal:
            complaints.about(path)
            message = f"{text} is read as {decimal}; YAML 1.1 has it for the octal number {octal}"
            complaints.warning("leading-zero", message, document.span(path), f"write {decimal}")


def _written(document: Document) -> Iterator[tuple[Path, str]]:
    """Whole numbers as they are written, in the file or on the command line."""
    for path, words in document.overrides.items():
        if type(document.get(path)) is int:
            yield path, words.partition("=")[2].strip()
    for path, place in document.places.items():
        if document.origin(path) is None and type(document.get(path)) is int:
            yield path, place.value.value or ""
