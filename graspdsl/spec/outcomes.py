"""How a trial can end: a name, what it means, and how a map shows it."""

from __future__ import annotations

from typing import ClassVar

# Hatchings as matplotlib writes them.
DOTS, LEVEL, STROKES = "......", "------", "//////"


_MADE: dict[str, Outcome] = {}


class Outcome(str):
    """A class of outcomes by its name. Every trial bears exactly one, and of each there is one object.

    ``means``: what it says of a trial, the times and bounds being those of the spec's monitors. ``settled``: whether
    the grasp came to where its controller brings it, or had all the time that every trial has, which cuts off no kind
    of course more than another; where a trial ended that a monitor stopped tells of what stopped it. A map shows an
    outcome by grey and hatching, which no two share; what has converged is in colour.
    """

    means: str
    grey: str
    hatching: str
    settled: bool

    CONVERGED: ClassVar[Outcome]
    TIMEOUT: ClassVar[Outcome]
    UNDONE: ClassVar[Outcome]
    TOPPLED: ClassVar[Outcome]
    INFEASIBLE_START: ClassVar[Outcome]
    CRASHED: ClassVar[Outcome]

    def __new__(
        cls, value: str, means: str, grey: str = "#8f98a2", hatching: str = "", *, settled: bool = False
    ) -> Outcome:
        """An outcome of this name."""
        made = super().__new__(cls, value)
        made.means, made.grey, made.hatching, made.settled = means, grey, hatching, settled
        return _MADE.setdefault(value, made)

    @property
    def value(self) -> str:
        """The name alone."""
        return str(self)

    def __reduce__(self) -> tuple[object, ...]:
        """What comes from another process is the one object that there is here."""
        return _named, (self.value,)


# Those that monitors do not make by themselves; an object may also topple before its trial begins.
Outcome.CONVERGED = Outcome(
    "converged", "the end conditions held, and the object had not been dragged", "", settled=True
)
Outcome.TIMEOUT = Outcome(
    "timeout", "time was up before the end conditions held, as the hand senses them", "#c9ced4", DOTS, settled=True
)
Outcome.UNDONE = Outcome(
    "undone",
    "a later stage of 'a then b' raised what an earlier one had lowered, and stayed so",
    "#c9ced4",
    STROKES,
    settled=True,
)
Outcome.TOPPLED = Outcome("toppled", "the object leant too far, or did not stand", "#5a636d", DOTS)
Outcome.INFEASIBLE_START = Outcome(
    "infeasible-start", "the world could take up no start that was drawn", "#ffffff", STROKES
)
Outcome.CRASHED = Outcome("crashed", "the simulation failed", "#23292f", DOTS)


def _named(value: str) -> Outcome:
    return _MADE[value]
