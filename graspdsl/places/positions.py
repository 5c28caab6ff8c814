"""Where things stand in a text: offsets to lines and columns, pieces that stand for a node, a scalar's characters."""

from __future__ import annotations

import bisect
import re
from dataclasses import dataclass

from yaml.scanner import Scanner

from graspdsl.diagnostics import SourceText, Span


@dataclass(frozen=True, slots=True)
class Piece:
    """The stretch of a file that one node takes: offsets of its first character and of the one after its last.

    A scalar also has its ``style`` (``'``, ``"``, ``|``, ``>``, or None when plain) and its ``value`` as text;
    a collection has no value, and ``flow`` says whether it is written in brackets.
    """

    start: int
    end: int
    style: str | None = None
    value: str | None = None
    flow: bool = False


class Lines:
    """Turns offsets in a text into lines and columns, both from 1 and counted in characters."""

    __slots__ = ("_starts", "text")

    def __init__(self, text: str) -> None:
        self.text = text
        self._starts = [0, *(i + 1 for i, character in enumerate(text) if character == "\n")]

    def place(self, offset: int) -> tuple[int, int]:
        """The (line, column) of a character."""
        line = bisect.bisect_right(self._starts, offset)
        return line, offset - self._starts[line - 1] + 1

    def span(self, start: int, end: int) -> Span:
        """The span of ``text[start:end]``; an empty stretch covers one character."""
        line, column = self.place(start)
        if end <= start:
            return Span(line, column, line, column + 1)
        end_line, end_column = self.place(end - 1)
        return Span(line, column, end_line, end_column + 1)

    def first_line(self, start: int, end: int) -> Span:
        """The span of ``text[start:end]`` up to the end of its first line."""
        cut = self.text.find("\n", start, end)
        return self.span(start, end if cut < 0 else cut)

    def rest_of_line(self, offset: int) -> str:
        """What stands on the line from ``offset`` on, without the blanks around it."""
        cut = self.text.find("\n", offset)
        return self.text[offset : len(self.text) if cut < 0 else cut].strip()

    def line_before(self, offset: int) -> str:
        """What stands on the line before ``offset``."""
        return self.text[self.text.rfind("\n", 0, offset) + 1 : offset]


Placed = list[tuple[str, int]]

# An anchor or a tag, and what may stand between it and its value.
_PROPERTIES = re.compile(r"(?:[&!]\S*(?:\s+|(?<=\s)#[^\n]*)*)*")
_BLANKS = " \t\n"


def source_text(lines: Lines, piece: Piece) -> SourceText:
    """The value of a scalar, each character with its place in the file.

    A line break that folding turned into a blank stands where the break is; a character written as an escape
    stands where the escape begins.
    """
    value = piece.value or ""
    start = _PROPERTIES.match(lines.text, piece.start, piece.end).end() if value else piece.start  # type: ignore[union-attr]  # the pattern matches the empty text
    if piece.style in ("|", ">"):
        placed = _block(lines.text, start, value, folded=piece.style == ">")
        end = placed[-1][1] + 1 if placed else start
    elif piece.style in ("'", '"'):
        end = piece.end - 1
        placed = _flow(lines.text, start + 1, end, piece.style)
    else:
        end = piece.end
        placed = _flow(lines.text, start, end, "") if value else []
    if "".join(character for character, _ in placed) != value:
        # A scalar of nothing but blanks does not show its own indentation: all of it stands at its start.
        return SourceText(value, (lines.place(start),) * (len(value) + 1))
    offsets = [offset for _, offset in placed]
    return SourceText(value, tuple(lines.place(offset) for offset in [*offsets, end]))


def _flow(text: str, start: int, end: int, style: str) -> Placed:
    """A plain or quoted scalar: line breaks fold, quotes and escapes stand for something else."""
    placed: Placed = []
    i = start
    while i < end:
        character = text[i]
        if character in _BLANKS:
            after = _skip_blanks(text, i, end)
            breaks = [k for k in range(i, after) if text[k] == "\n"]
            if not breaks:
                placed += [(text[k], k) for k in range(i, after)]
            elif len(breaks) == 1:
                placed.append((" ", breaks[0]))
            else:
                placed += [("\n", k) for k in breaks[1:]]
            i = after
        elif character == "'" and style == "'":
            placed.append(("'", i))
            i += 2
        elif character == "\\" and style == '"':
            i = _escape(text, i, end, placed)
        else:
            placed.append((character, i))
            i += 1
    return placed


def _skip_blanks(text: str, i: int, end: int) -> int:
    while i < end and text[i] in _BLANKS:
        i += 1
    return i


def _escape(text: str, i: int, end: int, placed: Placed) -> int:
    """Reads the escape at ``i`` and returns where the text goes on."""
    letter = text[i + 1]
    if letter == "\n":
        after = _skip_blanks(text, i + 2, end)
        placed += [("\n", k) for k in range(i + 2, after) if text[k] == "\n"]
        return after
    digits = Scanner.ESCAPE_CODES.get(letter)
    if digits is None:
        placed.append((Scanner.ESCAPE_REPLACEMENTS[letter], i))
        return i + 2
    placed.append((chr(int(text[i + 2 : i + 2 + digits], 16)), i))
    return i + 2 + digits


def _leading_blanks(line: str) -> int:
    return len(line) - len(line.lstrip(" "))


def _first_full(lines: list[str]) -> str | None:
    return next((line for line in lines if line.strip(" ")), None)


def _block(text: str, start: int, value: str, *, folded: bool) -> Placed:
    """A literal or folded block scalar that begins with its ``|`` or ``>`` at ``start``."""
    body = text.find("\n", start) + 1
    rows = text[body:].split("\n")
    shown, kept = _first_full(rows), _first_full(value.split("\n"))
    if not value or shown is None or kept is None:
        return []
    indent = _leading_blanks(shown) - _leading_blanks(kept)

    placed: Placed = []
    breaks: Placed = []  # line breaks not yet known to be inside the text
    pending: tuple[str, int] | None = None  # the break that ended the last full line
    was_flush = False
    offset = body
    for number, row in enumerate(rows):
        blanks = _leading_blanks(row)
        end = offset + len(row)
        line_break = [("\n", end)] if number < len(rows) - 1 else []
        if blanks == len(row) and blanks <= indent:
            breaks += line_break
        elif blanks < indent:
            break
        else:
            flush = row[indent] not in " \t"
            if pending and folded and was_flush and flush:
                placed += breaks or [(" ", pending[1])]
            else:
                placed += [pending, *breaks] if pending else breaks
            breaks = []
            placed += [(text[k], k) for k in range(offset + indent, end)]
            pending = line_break[0] if line_break else None
            was_flush = flush
        offset = end + 1
        if len(placed) > len(value):
            break
    placed += [pending, *breaks] if pending else breaks
    return placed[: len(value)]
