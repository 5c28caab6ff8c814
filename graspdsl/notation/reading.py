"""A formula as the grammar reads it, with the place of each of its characters in what the user wrote."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from graspdsl.diagnostics import SourceText, Span
from graspdsl.notation.characters import fold


@dataclass(frozen=True, slots=True)
class Reading:
    """``text`` is in the folded alphabet of the grammar; its ``i``-th character is ``source.text[starts[i]:ends[i]]``.

    ``spelt`` is as long as the text: how messages show it. Of LaTeX, which reads in another order than it is written
    and may say one thing of two places, that is the text itself; of all else, what the user wrote. ``end`` is where the
    text ends in the source.
    """

    text: str
    spelt: str
    source: SourceText
    starts: Sequence[int]
    ends: Sequence[int]
    end: int

    @classmethod
    def plain(cls, source: SourceText) -> Reading:
        """The reading of Unicode or ASCII, one for one."""
        count = len(source.text)
        return cls(fold(source.text), source.text, source, range(count), range(1, count + 1), count)

    def span(self, start: int, end: int) -> Span:
        """Where ``text[start:end]`` stands in the file; an empty stretch stands for the place where it begins."""
        return self.source.span(*self._extent(start, end))

    def written(self, start: int, end: int) -> str:
        """What the user wrote for ``text[start:end]``."""
        first, last = self._extent(start, end)
        return self.source.text[first:last]

    def part(self, start: int, end: int) -> Reading:
        """The reading of ``text[start:end]`` alone."""
        cut = slice(start, end)
        last = self._extent(end, end)[0]
        return Reading(self.text[cut], self.spelt[cut], self.source, self.starts[cut], self.ends[cut], last)

    def _extent(self, start: int, end: int) -> tuple[int, int]:
        if start < end:
            return min(self.starts[start:end]), max(self.ends[start:end])
        place = self.starts[start] if start < len(self.text) else self.end
        return place, place
