"""What a hand file still asks for: values that begin with TODO."""

from __future__ import annotations

from collections.abc import Iterator

from graspdsl.diagnostics import Diagnostic
from graspdsl.places.document import Document, Path
from graspdsl.places.wording import Data, shortened

TODO = "TODO"


def to_dos(document: Document) -> Iterator[Diagnostic]:
    """A complaint about each value that is still to be written, with what is said there of it."""
    waiting: list[tuple[Path, Data]] = [((), document.data)]
    while waiting:
        path, data = waiting.pop()
        if isinstance(data, list):
            waiting += [((*path, number), item) for number, item in enumerate(data)]
        elif isinstance(data, dict):
            waiting += [((*path, key), value) for key, value in data.items()]
        elif isinstance(data, str) and data.startswith(TODO):
            wanted = shortened(data.removeprefix(TODO).lstrip(": "), 100)
            message = f"fill in {'.'.join(map(str, path))}{f': {wanted}' if wanted else ''}"
            yield Diagnostic("to-do", message, document.span(path), f"write it in place of {TODO}")
