"""A complaint about a formula by offsets, before it is placed in the file."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

from graspdsl.diagnostics import Diagnostic, Fix, Span


class Placed(Protocol):
    """A text that knows where each of its stretches stands in a file."""

    def span(self, start: int, end: int) -> Span:
        """Where ``text[start:end]`` stands."""


@dataclass(frozen=True, slots=True, order=True)
class Fault:
    """What is wrong with ``text[start:end]`` of a formula; an empty stretch stands for the place behind the text.

    ``write``: what would be right instead, any of which is enough.
    """

    start: int
    end: int
    code: str
    message: str
    hint: str
    write: tuple[str, ...] = ()

    def shifted(self, offset: int) -> Fault:
        """The same complaint about a text of which this one was cut out at ``offset``."""
        return Fault(self.start + offset, self.end + offset, self.code, self.message, self.hint, self.write)

    def placed(self, source: Placed) -> Diagnostic:
        """The complaint with its place in the file."""
        span = source.span(self.start, self.end)
        return Diagnostic(self.code, self.message, span, self.hint, fixes=tuple(Fix(span, text) for text in self.write))
