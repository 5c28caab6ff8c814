"""How far something long is: rich's bar on a terminal, now and then a line elsewhere; always on stderr."""

from __future__ import annotations

import sys
import time
from collections import Counter
from collections.abc import Callable, Sequence
from typing import Self

import rich.progress
from rich.console import Console
from rich.progress import BarColumn, ProgressColumn, SpinnerColumn, Task
from rich.table import Column
from rich.text import Text

from graspdsl.trials.record import TrialRecord

BAR = 20  # cells
LINES = 10  # in all, where there is no terminal


def say(line: str) -> None:
    """A line on stderr."""
    print(line, file=sys.stderr, flush=True)


class Progress:
    """Steps done, of so many, and time left; on a terminal a sign of life before the first. For a ``with``.

    ``to``: what says a line where there is no terminal.
    """

    def __init__(self, asked: int, finished: int = 0, to: Callable[[str], None] = say) -> None:
        self._asked, self._before, self._done, self._to = asked, finished, finished, to
        self._began = time.monotonic()
        self._every = max(1, asked // LINES)
        console = Console(file=sys.stderr)
        self._live = sys.stderr.isatty() and not console.is_dumb_terminal and finished < asked
        self._bar = rich.progress.Progress(
            SpinnerColumn("line"),
            BarColumn(BAR),
            _Told(Column(no_wrap=True, overflow="ellipsis")),
            console=console,
            redirect_stdout=False,
            redirect_stderr=False,
            disable=not self._live,
        )
        self._task = self._bar.add_task("", total=asked, completed=finished, told=self.told)

    def __enter__(self) -> Self:
        self._bar.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._bar.stop()

    def step(self) -> None:
        """One more is done."""
        self._done += 1
        self._bar.update(self._task, completed=self._done, refresh=True)
        if not self._live and (self._done % self._every == 0 or self._done == self._asked):
            self._say()

    def told(self) -> str:
        """How many are done, the time left, or spent before the first and after the last, and what else there is."""
        return "  ".join(part for part in (f"{self._done}/{self._asked}", self._time(), self._note()) if part)

    def _say(self) -> None:
        filled = BAR * self._done // self._asked
        self._to(f"{'█' * filled}{'░' * (BAR - filled)} {self.told()}")

    def _note(self) -> str:
        return ""

    def _time(self) -> str:
        spent, newly = time.monotonic() - self._began, self._done - self._before
        if self._done == self._asked:
            return _duration(spent)
        if newly:
            return f"{_duration(spent / newly * (self._asked - self._done))} left"
        return f"{_duration(spent)} so far" if self._live else ""


class _Told(ProgressColumn):
    max_refresh = None

    def render(self, task: Task) -> Text:
        """What the progress says now."""
        return Text(task.fields["told"]())


class TrialProgress(Progress):
    """Trials done, outcomes so far and time left."""

    def __init__(self, asked: int, finished: Sequence[TrialRecord], to: Callable[[str], None] = say) -> None:
        self._outcomes = Counter(record.outcome.value for record in finished)
        self._drawing = ""
        super().__init__(asked, len(finished), to)

    def advance(self, record: TrialRecord) -> None:
        """One more trial is finished."""
        self._outcomes[record.outcome.value] += 1
        self._drawing = ""
        self.step()

    def draw_again(self, number: int, draws: int) -> None:
        """A trial still looks for a start, after so many draws that could not be taken up."""
        first = not self._drawing and not self._outcomes
        self._drawing = f"trial {number} looks for a start, {draws} draws so far"
        if first and not self._live:
            self._say()

    def _note(self) -> str:
        told = [f"{count} {name}" for name, count in self._outcomes.most_common()]
        return ", ".join([*told, *filter(None, [self._drawing])])


def _duration(seconds: float) -> str:
    minutes, rest = divmod(round(seconds), 60)
    return f"{minutes}:{rest:02d} min" if minutes else f"{rest} s"
