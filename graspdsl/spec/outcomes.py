"""How a trial can end: a name, what it means, and how a map shows it."""

from __future__ import annotations

from typing import ClassVar

# Hatchings as matplotlib writes them.
DOTS, LEVEL, STROKES = "......", "------", "//////"


_MADE: dict[str, Outcome] = {}


class Outcome(str):
    """A class of outcomes by its name. Every trial bears exactly one, and of each there is one object.

    ``means``: what it says of a trial, the times and bounds being those of the spec's monitors. A map shows it by grey
    and hatching, which no two outcomes share; what has converged is in colour.
    """

    means: str
    grey: str
    hatching: str

    CONVERGED: ClassVar[Outcome]
    TIMEOUT: ClassVar[Outcome]
    TOPPLED: ClassVar[Outcome]
    INFEASIBLE_START: ClassVar[Outcome]
    CRASHED: ClassVar[Outcome]

    def __new__(cls, value: str, means: str, grey: str = "#8f98a2", hatching: str = "") -> Outcome:
        """An outcome of this name."""
        made = super().__new__(cls, value)
        made.means, made.grey, made.hatching = means, grey, hatching
        return _MADE.setdefault(value, made)

    @property
    def value(self) -> str:
        """The name alone."""
        return str(self)

    def __reduce__(self) -> tuple[object, ...]:
        """What comes from another process is the one object that there is here."""
        return _named, (self.value,)


# Those that monitors do not make by themselves; an object may also topple before its trial begins.
Outcome.CONVERGED = Outcome("converged", "the end conditions held, and the object had not been dragged", "")
Outcome.TIMEOUT = Outcome(
    "timeout", "time was up before the end conditions held, as the hand senses them", "#c9ced4", DOTS
)
Outcome.TOPPLED = Outcome("toppled", "the object leant too far, or did not stand", "#5a636d", DOTS)
Outcome.INFEASIBLE_START = Outcome(
    "infeasible-start", "the world could take up no start that was drawn", "#ffffff", STROKES
)
Outcome.CRASHED = Outcome("crashed", "the simulation failed", "#23292f", DOTS)


def _named(value: str) -> Outcome:
    return _MADE[value]
