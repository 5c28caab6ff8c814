"""A YAML text written anew: its indentation, its blanks and the order of its keys.

Comments, blank lines between entries, blocks, brackets and the spelling of values stay. A comment above an entry goes
where the entry goes, one behind it stays behind it, and those above the first key stay at the top of the file.
"""

from __future__ import annotations

import re
from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass, field
from textwrap import wrap

import yaml
from yaml.events import AliasEvent, CollectionEndEvent, CollectionStartEvent, MappingStartEvent, ScalarEvent

from graspdsl.places.composing import kind_of, offset_of
from graspdsl.places.document import Path

WIDTH = 120  # characters of a line
STEP = 2  # of indentation
_PROPERTY = re.compile(r"[&!]\S*")  # an anchor or a tag
_BETWEEN = re.compile(r"(?:\s|#[^\n]*)*")
_COMMENT = re.compile(r"#[^\n]*")  # where no value is
_COMMA = re.compile(r"[ \t]*,?")
_BLANK_LINE = re.compile(r"\n[ \t]*\n")
_SIGNS = set("-?:,[]{}#&*!|>'\"%@`")


class Style(ABC):
    """What a kind of file asks of its text beyond what every YAML text is asked."""

    @abstractmethod
    def ranks(self, path: Path, keys: Sequence[str]) -> Sequence[int]:
        """The ranks of the keys of the mapping at a path: it is written by them, equal ones as they stand."""

    @abstractmethod
    def spelt(self, path: Path, text: str, *, key: bool) -> str | None:
        """How a text is written: the value at a path, or its key; None to leave it as it stands."""


@dataclass(slots=True)
class _Node:
    """A value: where it starts with its anchor and tag and begins without; for a collection its pairs of key and value,
    or its items with None for keys."""

    start: int
    begin: int
    end: int
    properties: str = ""
    value: str | None = None
    style: str | None = None
    flow: bool = False
    items: list[tuple[_Node | None, _Node]] = field(default_factory=list)

    @property
    def is_block(self) -> bool:
        """Whether it is a collection by indentation."""
        return self.value is None and not self.flow


@dataclass(frozen=True, slots=True)
class _Comment:
    start: int
    column: int
    text: str
    alone: bool  # on its line


@dataclass(slots=True)
class _Chunk:
    """An entry of a collection: what stands above it, its lines, and whether blank lines come before it."""

    above: list[str]
    lines: list[str]
    spaced: bool


def tidied(text: str, style: Style) -> str:
    """The text of one YAML document that is well-formed, with plain line ends, in a style. It means what it meant."""
    return _Tidying(text, style).whole()


class _Tidying:
    def __init__(self, text: str, style: Style) -> None:
        self._text, self._style = text, style
        self._at = 0  # all before this has been written
        events = list(yaml.parse(text, Loader=yaml.SafeLoader))[2:-2]
        self._has_aliases = any(isinstance(event, AliasEvent) for event in events)
        self._taken: list[tuple[int, int]] = []  # where values are
        self._root, _ = self._node(events, 0)
        self._comments = self._all_comments()

    def _node(self, events: Sequence[yaml.Event], place: int) -> tuple[_Node, int]:
        """The node that begins with an event, and the place of the event after it."""
        event = events[place]
        start, end = offset_of(event.start_mark), offset_of(event.end_mark)
        begin, kept = self._properties(event)
        if not isinstance(event, CollectionStartEvent):
            value = event.value if isinstance(event, ScalarEvent) else ""
            style = event.style if isinstance(event, ScalarEvent) else "*"
            raw = self._text[begin:end]
            if style in ("|", ">"):
                raw = raw.removesuffix("\n") if "+" in raw.partition("\n")[0] else raw.rstrip()
                end = begin + len(raw)
            self._taken.append((begin, end))
            return _Node(start, begin, end, kept, value, style), place + 1
        node = _Node(start, begin, end, kept, flow=bool(event.flow_style))
        place += 1
        while not isinstance(events[place], CollectionEndEvent):
            key = None
            if isinstance(event, MappingStartEvent):
                key, place = self._node(events, place)
            value_node, place = self._node(events, place)
            node.items.append((key, value_node))
        closing = offset_of(events[place].end_mark)
        node.end = closing if node.flow else node.items[-1][1].end
        return node, place + 1

    def _properties(self, event: yaml.Event) -> tuple[int, str]:
        """Where the value of an event begins, and the anchor and the tag before it."""
        at, found = offset_of(event.start_mark), list[str]()
        if isinstance(event, ScalarEvent | CollectionStartEvent):
            for _ in filter(None, (event.anchor, event.tag)):
                one = _PROPERTY.match(self._text, at)
                if one is not None:
                    self._taken.append(one.span())
                    found.append(one.group())
                    at = _end(_BETWEEN, self._text, one.end())
        return at, " ".join(found)

    def _all_comments(self) -> list[_Comment]:
        found, at = list[_Comment](), 0
        for begin, end in [*self._taken, (len(self._text), 0)]:
            for comment in _COMMENT.finditer(self._text, at, begin):
                line = self._text.rfind("\n", 0, comment.start()) + 1
                alone = not self._text[line : comment.start()].strip()
                found.append(_Comment(comment.start(), comment.start() - line, comment.group().rstrip(), alone))
            at = end
        return found

    def whole(self) -> str:
        """The text of the document."""
        root = self._root
        if not root.items or root.flow:
            above = self._above(root.begin)
            lines = self._flow(root, (), 0, "")
            lines[-1] += self._behind(root.end)
        else:
            above = self._above(root.begin)
            lines = [*filter(None, [root.properties]), *self._block(root, (), 0, (len(self._text), -1))]
        rest = self._above(len(self._text))
        while above and not above[0]:
            above.pop(0)
        while rest and not rest[-1]:
            rest.pop()
        return "\n".join([*above, *lines, *rest, ""])

    # Comments, in their order

    def _above(self, upto: int) -> list[str]:
        """The comments that are left before an offset, and an empty line for blank ones before each and at the end."""
        lines: list[str] = []
        while self._comments and self._comments[0].start < upto:
            comment = self._comments.pop(0)
            lines += [""] if self._is_blank_before(comment.start) else []
            lines.append(comment.text)
            self._at = comment.start + len(comment.text)
        return [*lines, *([""] if self._is_blank_before(upto) else [])]

    def _is_blank_before(self, offset: int) -> bool:
        return bool(_BLANK_LINE.search(self._text, self._at, offset)) if offset > self._at else False

    def _behind(self, end: int) -> str:
        """The comment that follows on the same line, with the blank before it; empty for none."""
        self._at = max(self._at, end)
        if not self._comments or self._text[end : self._comments[0].start].strip(" \t"):
            return ""
        comment = self._comments.pop(0)
        self._at = comment.start + len(comment.text)
        return f" {comment.text}"

    def _trailing(self, column: int, limit: tuple[int, int]) -> list[str]:
        """The comments at the end of a block in a column: no further left, and right of what comes at the limit."""
        lines: list[str] = []
        offset, next_column = limit
        while self._comments and self._comments[0].start < offset:
            comment = self._comments[0]
            if not comment.alone or comment.column < column or comment.column <= next_column:
                break
            lines += self._above(comment.start + 1)
        return lines

    # Blocks

    def _block(
        self, node: _Node, path: Path, indent: int, limit: tuple[int, int], first: Sequence[str] = ()
    ) -> list[str]:
        """The lines of a block; ``limit``: the offset and the column of what comes after it; ``first``: the comments
        above its first entry."""
        column = self._column(node)
        chunks: list[_Chunk] = []
        for number, (key, value) in enumerate(node.items):
            here = (*path, number if key is None else key.value or "")
            above = self._above((key or value).start) if number else [*first]
            spaced = bool(above) and not above[0]
            following = node.items[number + 1] if number + 1 < len(node.items) else None
            after = ((following[0] or following[1]).start, column) if following else limit
            more, lines = self._entry(key, value, here, (column, indent), after)
            chunks.append(_Chunk([*above[spaced:], *more], lines, spaced))
        pad = " " * indent
        written: list[str] = []
        order = self._order(node, path)
        for place, number in enumerate(order):
            chunk = chunks[number]
            before = order[place - 1] if place else None
            closed = before is not None and before + 1 < len(chunks) and chunks[before + 1].spaced
            written += [""] if before is not None and (chunk.spaced or closed) else []
            written += [pad + line if line else "" for line in chunk.above]
            written += chunk.lines
        return written + [pad + line if line else "" for line in self._trailing(column, limit)]

    def _column(self, node: _Node) -> int:
        """Where the keys of a block begin, or the dashes before its items."""
        start = node.begin
        return start - self._text.rfind("\n", 0, start) - 1

    def _order(self, node: _Node, path: Path) -> list[int]:
        numbers = list(range(len(node.items)))
        keys = [key.value or "" for key, _ in node.items if key is not None]
        if self._has_aliases or not keys:  # an alias may stand only behind its anchor
            return numbers
        ranks = self._style.ranks(path, keys)
        return sorted(numbers, key=lambda number: ranks[number])

    def _entry(
        self, key: _Node | None, value: _Node, path: Path, columns: tuple[int, int], limit: tuple[int, int]
    ) -> tuple[list[str], list[str]]:
        """An entry of a block, whose entries begin in the first column and are to begin in the second: comments that go
        above it, and its lines."""
        _, indent = columns
        head = "-" if key is None else f"{self._line(key, path, key=True)}:"
        pad = " " * indent
        if key is not None:
            self._at = key.end
        if not value.is_block:
            above = [line for line in self._above(value.begin) if line] if value.begin < value.end else []
            lines = self._value(value, path, columns, f"{pad}{head}")
            behind = "" if value.style in ("|", ">") else self._behind(value.end)
            self._at = max(self._at, value.end)
            return above, [*lines[:-1], lines[-1] + behind]
        behind = self._behind_head(value)
        above = self._above(value.begin)
        while above and not above[0]:
            above.pop(0)
        inner = self._block(value, path, indent + STEP, limit, above)
        properties = f" {value.properties}" if value.properties else ""
        if key is not None or properties:
            return [], [f"{pad}{head}{properties}{behind}", *inner]
        above = [behind.strip()] if behind else []
        while inner[0].lstrip().startswith("#") or not inner[0]:
            above += [line for line in [inner.pop(0).strip()] if line]
        return above, [f"{pad}{head} {inner[0].lstrip()}", *inner[1:]]

    def _behind_head(self, value: _Node) -> str:
        """The comment behind the key, or the dash, of a block."""
        if self._comments and self._comments[0].start < value.begin and not self._comments[0].alone:
            return self._behind(self._comments[0].start)
        return ""

    # Values

    def _value(self, node: _Node, path: Path, columns: tuple[int, int], head: str) -> list[str]:
        """The lines of a scalar or of a collection in brackets, behind the head of its entry."""
        column, indent = columns
        if node.value is None:
            return self._flow(node, path, indent + (STEP if head.endswith("-") else 0), f"{head} ")
        spelt = self._style.spelt(path, node.value, key=False) if node.style != "*" else None
        if spelt is None:
            first, *others = self._raw(node).split("\n")
            first = f"{head} {first}".rstrip()
            return [first, *(_shifted(line, indent - column, node.style in ("|", ">")) for line in others)]
        begin = " ".join(filter(None, [head, node.properties]))
        pad = " " * (indent + STEP)
        if node.style in ("|", ">"):
            sign, blank, comment = self._text[node.begin : node.end].split("\n")[0].partition(" ")
            kept = blank + comment.strip() if comment.strip() else ""
            return [f"{begin} {re.sub('[0-9]', '', sign)}{kept}", *_wrapped(spelt, pad, pad)]
        first, *others = _wrapped(_written(spelt, node.style, in_brackets=False), f"{begin} ", pad)
        return [first, *others]

    def _raw(self, node: _Node) -> str:
        return " ".join(filter(None, [node.properties, self._text[node.begin : node.end]]))

    def _line(self, node: _Node, path: Path, *, key: bool = False, in_brackets: bool = False) -> str:
        """A scalar on one line, in brackets or as a key; with line breaks where it cannot be on one."""
        if node.style == "*":
            return f"{self._raw(node)} " if key else self._raw(node)
        spelt = self._style.spelt(path, node.value or "", key=key)
        if key and spelt is None and _is_plain(node.value or "", in_brackets=in_brackets):
            spelt = node.value  # without quotes
        if spelt is not None:
            style = None if key else node.style
            return " ".join(filter(None, [node.properties, _written(spelt, style, in_brackets=in_brackets)]))
        raw = self._raw(node)
        if "\n" in raw and not re.search(r"\n[ \t]*\n|\\\n", raw):
            raw = " ".join(part.strip() for part in raw.split("\n"))
        return raw

    def _flow(self, node: _Node, path: Path, indent: int, head: str) -> list[str]:
        """The lines of a collection in brackets, the first behind a head."""
        begin, opening, closing = self._brackets(node, head)
        commented = any(node.begin < comment.start < node.end for comment in self._comments)
        pad = " " * (indent + STEP)
        chunks: list[_Chunk] = []
        for number, (key, value) in enumerate(node.items):
            here = (*path, number if key is None else key.value or "")
            above = [line for line in self._above((key or value).start) if line]
            name = "" if key is None else self._line(key, here, key=True, in_brackets=True)
            if key is not None:
                above += [line for line in self._above(value.begin) if line]
            if value.value is None:
                lines = self._flow(value, here, indent + STEP, f"{pad}{name}: " if name else pad)
            else:
                lines = [pad + ": ".join(filter(None, [name, self._line(value, here, in_brackets=True)]))]
            lines[-1] += f"\0{self._behind(_end(_COMMA, self._text, value.end))}"
            chunks.append(_Chunk(above, lines, False))
        left = [line for line in self._above(node.end) if line]
        self._at = node.end
        chunks = [chunks[number] for number in self._order(node, path)]
        single = all(len(chunk.lines) == 1 and "\n" not in chunk.lines[0] for chunk in chunks)
        if not commented and single:
            items = [chunk.lines[0].strip().replace("\0", "") for chunk in chunks]
            line = f"{begin}{opening}{', '.join(items)}{closing}"
            if len(line) <= WIDTH or not items:
                return [line]
            return [f"{begin}{opening}", *_filled(items, pad), " " * indent + closing]
        lines = [f"{begin}{opening}"]
        for number, chunk in enumerate(chunks):
            comma_text = "," if number + 1 < len(chunks) else ""
            lines += [pad + line for line in chunk.above]
            lines += [line.replace("\0", comma_text) for line in chunk.lines]
        return [*lines, *(pad + line for line in left), " " * indent + closing]

    def _brackets(self, node: _Node, head: str) -> tuple[str, str, str]:
        properties = f"{node.properties} " if node.properties else ""
        keyed = any(key is not None for key, _ in node.items) or self._text[node.begin : node.begin + 1] == "{"
        return (f"{head}{properties}", "{", "}") if keyed else (f"{head}{properties}", "[", "]")


def _written(text: str, style: str | None, *, in_brackets: bool) -> str:
    """A formula on one line as a scalar of a style: in double quotes, or in none where it had none and needs none."""
    if style is None and _is_plain(text, in_brackets=in_brackets):
        return text
    return '"' + text.replace("\\", "\\\\").replace('"', '\\"') + '"'


def _is_plain(text: str, *, in_brackets: bool) -> bool:
    """Whether a text can stand without quotes."""
    signs = (": ", " #", *(",[]{}" if in_brackets else ""))
    sound = text.isprintable() and text == text.strip() and text[:1] not in _SIGNS and not text.endswith(":")
    return sound and kind_of(text) == "str" and text != "<<" and not any(sign in text for sign in signs)


def _wrapped(text: str, first: str, others: str) -> list[str]:
    return wrap(
        text,
        WIDTH,
        initial_indent=first,
        subsequent_indent=others,
        break_long_words=False,
        break_on_hyphens=False,
        expand_tabs=False,
    )


def _filled(items: Sequence[str], pad: str) -> list[str]:
    """Items with commas between them, as many on a line as fit."""
    lines = [pad + items[0]]
    for item in items[1:]:
        if len(lines[-1]) + len(item) + 3 <= WIDTH:
            lines[-1] += f", {item}"
        else:
            lines[-1] += ","
            lines.append(pad + item)
    return lines


def _shifted(line: str, shift: int, blanks_count: bool) -> str:
    """A line of a scalar, further right or left; ``blanks_count``: those of a line without anything else, too."""
    if not line.strip() and not blanks_count:
        return ""
    blanks = len(line) - len(line.lstrip(" "))
    return " " * max(blanks + shift, 0) + line.lstrip(" ")


def _end(pattern: re.Pattern[str], text: str, at: int) -> int:
    found = pattern.match(text, at)
    return found.end() if found else at
