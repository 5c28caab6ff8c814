"""A halt of the parser, together with what the user wrote around it."""

from __future__ import annotations

import re
from dataclasses import dataclass

from graspdsl.notation.reading import Reading
from graspdsl.notation.syntax import Halt, Start

_WORD = re.compile(r"<\||[+-]?[0-9.]+(?:[eE][+-]?[0-9]+)?|\w+|\S")


@dataclass(frozen=True, slots=True)
class Situation:
    """What could have stood where reading came to a halt, and what stands there.

    ``accepted`` and ``kind`` are terminals of the grammar, see Halt. ``found`` is the word at the halt as the user
    wrote it, ``previous`` the one before it with folded characters; they are empty where there is none.
    """

    start: Start
    at: int
    kind: str
    found: str
    previous: str
    accepted: frozenset[str]
    owner: str
    role: str

    @classmethod
    def of(cls, halt: Halt, reading: Reading, start: Start) -> Situation:
        """The situation of a halt in a formula."""
        previous = ""
        for match in _WORD.finditer(reading.text, 0, halt.at):
            previous = match.group()
        found = reading.spelt[halt.at : halt.at + len(halt.word)]
        return cls(start, halt.at, halt.kind, found, previous, halt.accepted, halt.owner, halt.role)

    def could_be(self, *terminals: str) -> bool:
        """Whether each of the terminals could have stood here."""
        return self.accepted.issuperset(terminals)
