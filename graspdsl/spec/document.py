"""A YAML file as plain data that knows where every key and value stands."""

from __future__ import annotations

import copy
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path as FilePath
from typing import Any

from graspdsl.diagnostics import Diagnostic, DiagnosticError, SourceText, Span, in_reading_order
from graspdsl.spec.composing import compose
from graspdsl.spec.constructing import Constructor, Path, Place
from graspdsl.spec.files import SIZE_LIMIT, read_text, too_large, with_plain_line_ends
from graspdsl.spec.positions import Lines, Piece
from graspdsl.spec.scalars import source_text
from graspdsl.spec.wording import Data, shown


@dataclass(frozen=True, slots=True)
class Document:
    """The data of a file (not to be changed) and the places of its nodes.

    A path is a tuple of keys and list numbers, ``("program", 0, "run")``; ``()`` is the whole document. ``text`` has
    ``\\n`` line ends and no byte order mark. ``overrides`` names what did not come from the file but from the
    command line: the paths of such values, each with the words that introduce a complaint about it.
    """

    name: str
    data: dict[str, Data]
    lines: Lines
    places: Mapping[Path, Place]
    overrides: Mapping[Path, str]

    @property
    def text(self) -> str:
        """The text of the file."""
        return self.lines.text

    def span(self, path: Path) -> Span | None:
        """The span of a value, or of the nearest enclosing one; None when it did not come from the file."""
        if self.origin(path) is not None:
            return None
        piece = self._nearest(path)[1].value
        return self.lines.span(piece.start, piece.end)

    def key_span(self, path: Path) -> Span | None:
        """The span of a value's key, or of the nearest enclosing one's; the first line of what has no key.

        None when the value did not come from the file.
        """
        if self.origin(path) is not None:
            return None
        place = self._nearest(path)[1]
        piece = place.key or place.value
        return self.lines.first_line(piece.start, piece.end)

    def source_text(self, path: Path) -> SourceText:
        """A text (or the text of a number) with the place of each of its characters.

        Places in a value that did not come from the file count from 1:1 of the value itself; see :meth:`attributed`.
        Raises :class:`KeyError` when there is no such value or it is a collection.
        """
        if self.origin(path) is not None:
            value = self.get(path)
            if not isinstance(value, str):
                raise KeyError(path)
            return SourceText.of(value)
        piece = self.places[path].value
        if piece.value is None:
            raise KeyError(path)
        return source_text(self.lines, piece)

    def key_source_text(self, path: Path) -> SourceText:
        """A key with the place of each of its characters; places as in :meth:`source_text`.

        Raises :class:`KeyError` when there is no such key.
        """
        if self.origin(path) is not None or path not in self.places:
            self.get(path)
            return SourceText.of(str(path[-1]))
        piece = self.places[path].key
        if piece is None:
            raise KeyError(path)
        return source_text(self.lines, piece)

    def source(self, path: Path) -> str | None:
        """What stands in the file for a value, quotes and brackets included; None when it is not from the file."""
        place = self.places.get(path)
        if place is None or self.origin(path) is not None:
            return None
        return self.text[place.value.start : place.value.end]

    def is_flow(self, path: Path) -> bool:
        """Whether a value stands in the file as a list or mapping in brackets."""
        place = self.places.get(path)
        return place is not None and place.value.flow and self.origin(path) is None

    def get(self, path: Path) -> Data:
        """The value at a path. Raises :class:`KeyError` when there is none."""
        value: Data = self.data
        for step in path:
            if isinstance(value, dict) and step in value:
                value = value[str(step)]
            elif isinstance(value, list) and step in range(len(value)):
                value = value[int(step)]
            else:
                raise KeyError(path)
        return value

    def origin(self, path: Path) -> str | None:
        """The words that introduce a complaint about an overridden value, None for what comes from the file."""
        return next((self.overrides[path[:n]] for n in range(len(path), -1, -1) if path[:n] in self.overrides), None)

    def attributed(self, path: Path, diagnostic: Diagnostic) -> Diagnostic:
        """A diagnostic about the value at ``path`` as the user should see it.

        What came from the file stays as it is; for a value that is overridden, or holds one that is, the place is
        dropped and the message begins with the override.
        """
        inside = (words for place, words in self.overrides.items() if place[: len(path)] == path)
        origin = self.origin(path) or next(inside, None)
        if origin is None:
            return diagnostic
        return replace(diagnostic, span=None, message=f"{origin}: {diagnostic.message}")

    def with_value(self, path: Path, value: Data, origin: str) -> Document:
        """The document with another value at a path whose enclosing value exists (as :meth:`get` finds it)."""
        data = copy.deepcopy(self.data)
        at: Any = data
        for step in path[:-1]:
            at = at[step]
        at[path[-1]] = value
        kept = {place: words for place, words in self.overrides.items() if place[: len(path)] != path}
        return replace(self, data=data, overrides={**kept, path: origin})

    def renamed(self, names: Mapping[Path, str]) -> Document:
        """The document with other keys in place of those at some paths; what is there keeps its place in the file."""

        def new(path: Path) -> Path:
            return tuple(names.get(path[: n + 1], step) for n, step in enumerate(path))

        def again(data: Data, path: Path) -> Data:
            if isinstance(data, dict):
                return {names.get((*path, key), key): again(value, (*path, key)) for key, value in data.items()}
            return [again(item, (*path, n)) for n, item in enumerate(data)] if isinstance(data, list) else data

        data = again(self.data, ())
        assert isinstance(data, dict)
        places = {new(path): place for path, place in self.places.items()}
        overrides = {new(path): words for path, words in self.overrides.items()}
        return replace(self, data=data, places=places, overrides=overrides)

    def _nearest(self, path: Path) -> tuple[Path, Place]:
        return next((path[:n], self.places[path[:n]]) for n in range(len(path), -1, -1) if path[:n] in self.places)


Faults = list[tuple[Path | None, Diagnostic]]


def parse_value(lines: Lines) -> tuple[Data, Lines, Mapping[Path, Place], Faults]:
    """Any YAML value, the text as it was read, the places in it, and its faults with their paths (None for none).

    Raises :class:`DiagnosticError` when the text cannot be read as one value.
    """
    node, lines, text_faults = compose(lines)
    if node is None:
        return None, lines, {(): Place(Piece(0, 0))}, [(None, fault) for fault in text_faults]
    constructor = Constructor(lines)
    data = constructor.build(node)
    return data, lines, constructor.places, [*((None, fault) for fault in text_faults), *constructor.faults]


def parse_with_faults(text: str, name: str) -> tuple[Document, Faults]:
    """A document and the faults that did not keep it from being read, for a caller that goes on to find more.

    Raises :class:`DiagnosticError` when there is no reading it at all.
    """
    size = len(text.encode("utf-8", errors="surrogatepass"))
    if size > SIZE_LIMIT:
        raise too_large(size)
    data, lines, places, faults = parse_value(Lines(with_plain_line_ends(text)))
    if data is None:
        empty = Diagnostic("empty-file", "there is nothing in this file", hint="begin with: graspdsl: 1")
        raise DiagnosticError([empty])
    if not isinstance(data, dict):
        piece = places[()].value
        message = f"expected keys with values, found {shown(data)}"
        span = lines.first_line(piece.start, piece.end)
        diagnostic = Diagnostic("not-a-mapping", message, span, "write one 'key: value' a line")
        raise DiagnosticError([*(fault for _, fault in faults), diagnostic])
    return Document(name, data, lines, places, {}), faults


def parse_document(text: str, name: str) -> Document:
    """The document of a YAML text; ``name`` is what messages call it.

    Raises :class:`DiagnosticError` when the text is not one YAML mapping within the bounds, with every duplicate
    key, tag and key that is no text at once.
    """
    document, faults = parse_with_faults(text, name)
    if faults:
        raise DiagnosticError(in_reading_order(fault for _, fault in faults))
    return document


def read_document(path: FilePath) -> Document:
    """The document of a YAML file.

    Raises :class:`DiagnosticError` when the file cannot be read, and as :func:`parse_document` does.
    """
    return parse_document(read_text(path), path.name)
