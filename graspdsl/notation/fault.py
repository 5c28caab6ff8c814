"""A complaint about a formula by offsets, before it is placed in the file."""

from __future__ import annotations

from dataclasses import dataclass

from graspdsl.diagnostics import Diagnostic, SourceText


@dataclass(frozen=True, slots=True, order=True)
class Fault:
    """What is wrong with ``text[start:end]`` of a formula; an empty stretch stands for the place behind the text."""

    start: int
    end: int
    code: str
    message: str
    hint: str

    def shifted(self, offset: int) -> Fault:
        """The same complaint about a text of which this one was cut out at ``offset``."""
        return Fault(self.start + offset, self.end + offset, self.code, self.message, self.hint)

    def placed(self, source: SourceText) -> Diagnostic:
        """The complaint with its place in the file."""
        return Diagnostic(self.code, self.message, source.span(self.start, self.end), self.hint)
