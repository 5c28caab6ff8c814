"""Where a place is among the keys of a YAML text, as far as the text before it tells: it may be half written."""

from __future__ import annotations

import re
from dataclasses import dataclass, field

from graspdsl.editor.sheet import Place
from graspdsl.places.document import Path

_KEY = re.compile(r"""\s*("(?:[^"\\]|\\.)*"|'(?:[^']|'')*'|[^\s"'#][^#]*?)\s*:(?=\s|$)[ \t]*""")
_PROPERTIES = re.compile(r"\A(?:[&!]\S*\s+)+")
_COMMENT = re.compile(r"(?:^|(?<=\s))#.*")


@dataclass(frozen=True, slots=True)
class Cursor:
    """``path``: of the mapping or list that a key or an item is begun in, or of the value that is.

    ``in_value``: whether it is a value, behind its key; ``begun``: what stands of it before the place, without the
    quotation mark. In a comment all is empty.
    """

    path: Path = ()
    in_value: bool = False
    begun: str = ""
    is_comment: bool = False


@dataclass(slots=True)
class _Frame:
    """A bracket that is open, with the key or the number of the item that is being written."""

    bracket: str
    step: str | int | None = None


@dataclass(slots=True)
class _Level:
    """A key or an item of a block, and how far it is indented."""

    indent: int
    step: str | int
    is_item: bool = False


@dataclass(slots=True)
class _Scanner:
    levels: list[_Level] = field(default_factory=list)
    frames: list[_Frame] = field(default_factory=list)
    items: dict[Path, int] = field(default_factory=dict)
    quote: str = ""
    begun: str = ""
    in_value: bool = False
    block: int | None = None  # the indentation of the key of a literal or folded text
    opened: int = 0  # that of the key or item of what is in brackets or in quotation marks
    comment: bool = False

    def line(self, row: str) -> None:
        """Takes the next line, or what of the last one stands before the place."""
        self.comment = False
        indent = len(row) - len(row.lstrip(" "))
        if self.block is not None:
            if not row.strip() or indent > self.block:
                self.begun = f"{self.begun} {row.lstrip()}".lstrip()
                return
            self.block = None
        if row.strip() and indent <= self.opened:  # what is open there would have to be indented further
            self.frames, self.quote = [], ""
        if self.frames or self.quote:
            self._flow(row if not self.quote else f" {row.lstrip()}")
            return
        rest = row[indent:]
        if rest.startswith("#"):
            self.comment = True
            return
        self.begun, self.in_value = "", False
        if not rest:
            return
        self._leave(indent)
        while rest.startswith("- ") or rest == "-":
            self.levels = [at for at in self.levels if at.indent < indent or (at.indent == indent and not at.is_item)]
            around = self._path()
            number = self.items[around] = self.items.get(around, -1) + 1
            self.levels.append(_Level(indent, number, is_item=True))
            inner = rest[1:].lstrip(" ")
            indent += len(rest) - len(inner)
            rest = inner
        key = _KEY.match(rest)
        self._leave(indent, for_key=True)
        if key is None or rest[:1] in ("{", "["):
            self._value(rest, indent - 1)
            return
        self.levels.append(_Level(indent, _unquoted(key.group(1))))
        self.in_value = True
        self._value(rest[key.end() :], indent)

    def _leave(self, indent: int, *, for_key: bool = False) -> None:
        """Closes what a line of this indentation is no part of."""
        self.levels = [at for at in self.levels if at.indent < indent or (not for_key and at.indent == indent)]

    def _value(self, text: str, indent: int) -> None:
        text = _PROPERTIES.sub("", text)
        if re.match(r"[|>][-+0-9]*\s*(#|$)", text):
            self.block = indent
        elif text[:1] in ("{", "[", "'", '"'):
            self.opened = indent
            self._flow(text)
        else:
            self.comment = _COMMENT.search(text) is not None
            self.begun = text

    def _flow(self, text: str) -> None:
        """Takes text in brackets or in quotation marks."""
        place = 0
        while place < len(text):
            character = text[place]
            place += 1
            if self.quote:
                if character == "\\" and self.quote == '"':
                    self.begun += text[place - 1 : place + 1]
                    place += 1
                elif character == self.quote:
                    self.quote = ""
                else:
                    self.begun += character
            elif character in ("'", '"') and not self.begun.strip():
                self.quote, self.begun = character, ""
            elif not self.frames and character not in "{[":
                continue
            elif character == "#" and text[place - 2 : place - 1] in ("", " "):
                self.comment = True
                return
            else:
                self._sign(character, text[place : place + 1])

    def _sign(self, character: str, following: str) -> None:
        frame = self.frames[-1] if self.frames else None
        if character in "{[":
            self.frames.append(_Frame(character, 0 if character == "[" else None))
            self.begun, self.in_value = "", character == "["
        elif character in "}]":
            self.frames.pop()
            self.begun, self.in_value = "", True
        elif character == "," and frame is not None:
            frame.step = frame.step + 1 if isinstance(frame.step, int) else None
            self.begun, self.in_value = "", frame.bracket == "["
        elif character == ":" and following in ("", " ") and frame is not None and frame.bracket == "{":
            frame.step, self.begun, self.in_value = self.begun.strip(), "", True
        elif not (character in " \t" and not self.begun):
            self.begun += character

    def _path(self) -> Path:
        inner = (frame.step for frame in self.frames if frame.step is not None)
        return (*(level.step for level in self.levels), *inner)

    def cursor(self, column: int) -> Cursor:
        """What is at the end of the last line."""
        if self.comment:
            return Cursor(is_comment=True)
        if not self.begun and not self.in_value and not self.frames:
            self.levels = [at for at in self.levels if at.indent < column - 1]
        return Cursor(self._path(), self.in_value, self.begun)


def cursor_at(text: str, place: Place) -> Cursor:
    """Where a place is, by the text before it."""
    line, column = place
    rows = text.split("\n")[:line]
    scanner = _Scanner()
    for row in rows[:-1]:
        scanner.line(row.rstrip("\r"))
    scanner.line(rows[-1][: column - 1])
    return scanner.cursor(column)


def key_at(text: str, place: Place) -> tuple[Path, int, int] | None:
    """The path of the key that a place is in, with the columns where it begins and where it has ended."""
    line, column = place
    row = text.split("\n")[line - 1]
    end = column - 1
    while end < len(row) and row[end] not in ":,{}[]#\"'":
        end += 1
    closing = end + 1 if row[end : end + 1] in ("'", '"') else end
    if row[closing : closing + 1] != ":":
        return None
    cursor = cursor_at(text, (line, end + 1))
    key = cursor.begun.strip()
    start = end - len(cursor.begun.lstrip())
    if cursor.in_value or cursor.is_comment or not key or column - 1 < start:
        return None
    return (*cursor.path, key), start + 1, end + 1


def _unquoted(key: str) -> str:
    return key[1:-1] if len(key) > 1 and key[0] in "'\"" and key[-1] == key[0] else key
