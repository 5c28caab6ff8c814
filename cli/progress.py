"""How far something long is: a bar on a terminal, now and then a line elsewhere; always on stderr."""

from __future__ import annotations

import os
import sys
import time
from collections import Counter
from collections.abc import Sequence
from typing import Self

from graspdsl.cli.messages import say, write
from graspdsl.trials.record import Trial, TrialRecord

BAR = 20  # cells
LINES = 10  # in all, where there is no terminal


class Progress:
    """Steps done, of so many, and time left. To be used in a ``with``."""

    def __init__(self, asked: int, finished: int = 0) -> None:
        self._asked, self._before, self._done = asked, finished, finished
        self._began = time.monotonic()
        self._live = sys.stderr.isatty()
        self._every = max(1, asked // LINES)

    def __enter__(self) -> Self:
        if self._done < self._asked:
            self._draw()
        return self

    def __exit__(self, *_: object) -> None:
        if self._live and self._before < self._asked:
            write(sys.stderr, "\n")

    def step(self) -> None:
        """One more is done."""
        self._done += 1
        if self._live:
            self._draw()
        elif self._done % self._every == 0 or self._done == self._asked:
            say(self._line())

    def _draw(self) -> None:
        if self._live:
            line = self._line()
            write(sys.stderr, f"\r\x1b[K{line[: _width() - 1]}")

    def _line(self) -> str:
        filled = BAR * self._done // self._asked
        bar = "█" * filled + "░" * (BAR - filled)
        return "  ".join(part for part in (f"{bar} {self._done}/{self._asked}", self._time(), self._note()) if part)

    def _note(self) -> str:
        return ""

    def _time(self) -> str:
        spent, newly = time.monotonic() - self._began, self._done - self._before
        if self._done == self._asked:
            return f"{_duration(spent)}"
        return f"{_duration(spent / newly * (self._asked - self._done))} left" if newly else ""


class TrialProgress(Progress):
    """Trials done, outcomes so far and time left."""

    def __init__(self, asked: int, finished: Sequence[TrialRecord]) -> None:
        super().__init__(asked, len(finished))
        self._outcomes = Counter(record.outcome.value for record in finished)
        self._drawing = ""

    def advance(self, trial: Trial) -> None:
        """One more trial is finished."""
        self._outcomes[trial.record.outcome.value] += 1
        self._drawing = ""
        self.step()

    def draw_again(self, number: int, draws: int) -> None:
        """A trial still looks for a start, after so many draws that could not be taken up."""
        first = not self._drawing and not self._outcomes
        self._drawing = f"trial {number} looks for a start, {draws} draws so far"
        if self._live:
            self._draw()
        elif first:
            say(self._line())

    def _note(self) -> str:
        told = [f"{count} {name}" for name, count in self._outcomes.most_common()]
        return ", ".join([*told, *filter(None, [self._drawing])])


def _duration(seconds: float) -> str:
    minutes, rest = divmod(round(seconds), 60)
    return f"{minutes}:{rest:02d} min" if minutes else f"{rest} s"


def _width() -> int:
    try:
        return os.get_terminal_size(sys.stderr.fileno()).columns or 80
    except OSError:
        return 80
