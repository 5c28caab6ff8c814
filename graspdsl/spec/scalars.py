"""Which character of the file each character of a scalar's value comes from."""

from __future__ import annotations

import re

from yaml.scanner import Scanner

from graspdsl.diagnostics import SourceText
from graspdsl.spec.positions import Lines, Piece

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
