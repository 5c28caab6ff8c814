"""Where things stand in a text: offsets to lines and columns, and pieces of the text that stand for a node."""

from __future__ import annotations

import bisect
from dataclasses import dataclass

from graspdsl.diagnostics import Span


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
