"""A YAML file as plain data that knows where every key and value stands."""

from __future__ import annotations

import copy
import re
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

from yaml.nodes import CollectionNode, MappingNode, Node, ScalarNode, SequenceNode

from graspdsl.diagnostics import Diagnostic, DiagnosticError, SourceText, Span, in_reading_order
from graspdsl.places.composing import DEPTH_LIMIT, NODE_LIMIT, compose, too_deep, too_many_nodes
from graspdsl.places.files import SIZE_LIMIT, too_large, with_plain_line_ends
from graspdsl.places.positions import Lines, Piece, source_text
from graspdsl.places.wording import Data, quoted, shortened, shown

Path = tuple[str | int, ...]

_NUMBER_WIDTH = 100  # characters; longer ones are slips, and slow to convert
_KIND_WORDS = {"null": "nothing", "bool": "a truth value", "int": "a number", "float": "a number"}
# What an escape can bring in: control characters and halves of surrogate pairs.
_CONTROL = re.compile("[\\x00-\\x08\\x0b-\\x1f\\x7f-\\x9f\\u2028\\u2029\\ud800-\\udfff]")


@dataclass(frozen=True, slots=True)
class Place:
    """Where a value stands and, in a mapping, where its key does."""

    value: Piece
    key: Piece | None = None


class Constructor:
    """Builds the data of one document; ``places`` and ``faults`` (with the path of each) fill on the way."""

    def __init__(self, lines: Lines) -> None:
        self.places: dict[Path, Place] = {}
        self.faults: list[tuple[Path, Diagnostic]] = []
        self._lines = lines
        self._nodes = 0
        self._open: list[Node] = []

    def build(self, node: Node, path: Path = (), key: Piece | None = None) -> Data:
        """The data of a node.

        Raises :class:`DiagnosticError` where it cannot go on: an anchor that contains itself, an expansion beyond
        the bounds. Other faults are collected.
        """
        piece = self._piece(node)
        self.places[path] = Place(piece, key)
        self._enter(node, key or piece)
        data: Data
        if isinstance(node, MappingNode):
            data = {name: self.build(value, (*path, name), piece) for name, piece, value in self._pairs(node, path)}
        elif isinstance(node, SequenceNode):
            data = [self.build(item, (*path, number)) for number, item in enumerate(node.value)]
        else:
            data = self._scalar(node, piece, path)
        self._open.pop()
        return data

    def _enter(self, node: Node, around: Piece) -> None:
        """Counts a node and holds the bounds."""
        self._nodes += 1
        if self._nodes > NODE_LIMIT:
            raise too_many_nodes(self._lines, around.start, around.end)
        if any(node is other for other in self._open):
            span = self._lines.first_line(node.start_mark.index, node.end_mark.index)
            hint = "remove the alias (*name) to it from what it names"
            raise DiagnosticError([Diagnostic("recursive-anchor", "this anchor contains itself", span, hint)])
        if len(self._open) > DEPTH_LIMIT:
            raise too_deep(self._lines, around.start, around.end)
        self._open.append(node)

    def _piece(self, node: Node) -> Piece:
        start, end = node.start_mark.index, node.end_mark.index
        if isinstance(node, ScalarNode):
            return Piece(start, self._trimmed(start, end), node.style, node.value)
        flow = isinstance(node, CollectionNode) and bool(node.flow_style)
        if not flow:
            # The end mark of a block lies at the next token, behind blank lines and comments.
            end = self._trimmed(start, self._end(node))
        return Piece(start, end, flow=flow)

    def _trimmed(self, start: int, end: int) -> int:
        return start + len(self._lines.text[start:end].rstrip())

    def _end(self, node: Node) -> int:
        """Where the last value of a block ends."""
        while isinstance(node, CollectionNode) and not node.flow_style and node.value:
            last = node.value[-1][1] if isinstance(node, MappingNode) else node.value[-1]
            if last.start_mark.index <= node.start_mark.index:  # an alias: its node stands before
                break
            node = last
        return int(node.end_mark.index)

    def _fault(self, code: str, message: str, piece: Piece, path: Path, hint: str | None) -> None:
        span = self._lines.first_line(piece.start, piece.end)
        self.faults.append((path, Diagnostic(code, message, span, hint)))

    def _scalar(self, node: Node, piece: Piece, path: Path) -> Data:
        text = str(node.value)
        bad = _CONTROL.search(text)
        if bad:
            line, column = source_text(self._lines, piece).places[bad.start()]
            message = f"the text holds the control character U+{ord(bad.group()):04X}"
            hint = "remove this escape; in single quotes a backslash is just a backslash"
            span = Span(line, column, line, column + 2)
            self.faults.append((path, Diagnostic("bad-character", message, span, hint)))
            return None
        if node.tag in ("int", "float"):
            if len(text) > _NUMBER_WIDTH:
                message = f"this number has {len(text)} characters"
                self._fault("number-too-long", message, piece, path, "put it in quotes if it is a text")
                return 0
            if node.tag == "int":
                return int(text, 0 if text[:2] in ("0o", "0x") else 10)
            return float(text.lower().replace(".inf", "inf").replace(".nan", "nan"))
        if node.tag == "bool":
            return text.lower() == "true"
        return None if node.tag == "null" else text

    def _pairs(self, mapping: MappingNode, path: Path) -> list[tuple[str, Piece, Node]]:
        """The keys of a mapping with their places and value nodes, those that ``<<`` brings in last."""
        pairs: dict[str, tuple[Piece, Node]] = {}
        merges: list[tuple[Piece, Node]] = []
        for key, value in mapping.value:
            piece = self._piece(key)
            if piece.value == "<<" and piece.style is None:
                merges.append((piece, value))
                continue
            name = self._key(key, piece, mapping, path)
            if name is None:
                continue
            if name in pairs:
                line = self._lines.place(pairs[name][0].start)[0]
                message = f"the key {shortened(name)!r} stands here for the second time; the first is on line {line}"
                hint = self._set_hint(mapping) or "remove one of the two"
                self._fault("duplicate-key", message, piece, (*path, name), hint)
                continue
            pairs[name] = piece, value
        for piece, value in merges:
            for name, place, node in self._merged(piece, value, path):
                pairs.setdefault(name, (place, node))
        return [(name, piece, node) for name, (piece, node) in pairs.items()]

    def _merged(self, key: Piece, node: Node, path: Path) -> list[tuple[str, Piece, Node]]:
        """What ``<<`` brings in; of two mappings in a list the first wins."""
        sources = node.value if isinstance(node, SequenceNode) else [node]
        merged: list[tuple[str, Piece, Node]] = []
        for source in sources:
            if not isinstance(source, MappingNode):
                message = "'<<' takes a mapping, or a list of mappings, to take keys from"
                self._fault("bad-merge", message, key, path, "write an alias (<<: *name), or put the key in quotes")
                continue
            self._enter(source, key)
            merged += self._pairs(source, path)
            self._open.pop()
        return merged

    def _key(self, node: Node, piece: Piece, mapping: MappingNode, path: Path) -> str | None:
        if not isinstance(node, ScalarNode):
            what = "list" if isinstance(node, SequenceNode) else "mapping"
            message = f"YAML reads this as a {what}, and a {what} cannot be a key"
            self._fault("key-not-text", message, piece, path, self._set_hint(mapping) or "a key is a text")
            return None
        if node.tag in _KIND_WORDS:
            message = f"YAML reads the key {shortened(node.value)!r} as {_KIND_WORDS[node.tag]}, not as text"
            hint = f"put it in quotes: {quoted(node.value)}" if node.value else "write a key before the colon"
            self._fault("key-not-text", message, piece, path, hint)
            return None
        name = self._scalar(node, piece, path)
        return None if name is None else str(name)

    def _set_hint(self, mapping: MappingNode) -> str | None:
        """The hint for what looks like a set of resources that lacks its quotes."""
        if not mapping.flow_style or any(value.start_mark.index != value.end_mark.index for _, value in mapping.value):
            return None
        text = self._lines.text[mapping.start_mark.index : mapping.end_mark.index]
        return f"a set of resources needs quotes: {quoted(text)}"


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

    def has(self, path: Path) -> bool:
        """Whether there is a value at a path, and not null."""
        try:
            return self.get(path) is not None
        except KeyError:
            return False

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
        return replace(diagnostic, span=None, message=f"{origin}: {diagnostic.message}", fixes=())

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
