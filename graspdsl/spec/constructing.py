"""YAML nodes to plain data, with the place of every key and value."""

from __future__ import annotations

import re
from dataclasses import dataclass

from yaml.nodes import CollectionNode, MappingNode, Node, ScalarNode, SequenceNode

from graspdsl.diagnostics import Diagnostic, DiagnosticError, Span
from graspdsl.spec.composing import DEPTH_LIMIT, NODE_LIMIT, too_deep, too_many_nodes
from graspdsl.spec.positions import Lines, Piece
from graspdsl.spec.scalars import source_text
from graspdsl.spec.wording import Data, quoted, shortened

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
