"""Folders of descriptions: YAML files that say what they describe, each beside its models and meshes."""

from __future__ import annotations

import re
from collections.abc import Iterable
from dataclasses import replace
from pathlib import Path

from graspdsl.diagnostics import Diagnostic, Span
from graspdsl.places.files import read_text, refusal

SUFFIXES = (".yaml", ".yml")
BEGINNING = 4096  # characters of a file in which it says what it is
HAND_FILE = re.compile(r"(?:[^\S\n]*(?:#[^\n]*)?\n)*hand\s*:")  # the beginning of one
MOUNT_FILE = re.compile(HAND_FILE.pattern.replace("hand", "mount"))


def names_a_file(name: str) -> bool:
    """Whether the name of a hand or of a mount is that of a file."""
    return name.endswith(SUFFIXES)


def descriptions_in(place: Path, kind: str) -> list[Path]:
    """The file of this name, or those of a folder that describe a kind of thing: YAML files with it for a key.

    Raises DiagnosticError for a file that cannot be read, and where there is none.
    """
    if place.is_file():
        return [place]
    files = [path for path in sorted(place.glob("*")) if path.suffix in SUFFIXES]
    found = [path for path in files if re.search(rf"^{kind}\s*:", read_text(path), re.MULTILINE)]
    if not found:
        message = f"there is no description of a {kind} in {place.name}"
        raise refusal("nothing-described", message, f"put a YAML file there that begins with '{kind}: NAME'")
    return found


def begins_as(beginning: re.Pattern[str], path: Path) -> bool:
    """Whether a YAML file is a hand or a mount file, as it begins; not where it cannot be read."""
    try:
        with path.open(encoding="utf-8", errors="replace") as file:
            return path.suffix in SUFFIXES and beginning.match(file.read(BEGINNING)) is not None
    except OSError:
        return False


def told_of(file: str, faults: Iterable[Diagnostic]) -> tuple[Diagnostic, ...]:
    """Complaints about a file as they are told elsewhere: each begins with its place in it."""
    return tuple(
        replace(fault, span=None, message=f"{_place(file, fault.span)}: {fault.message}", fixes=()) for fault in faults
    )


def _place(file: str, span: Span | None) -> str:
    return file if span is None else f"{file}:{span.line}:{span.column}"
