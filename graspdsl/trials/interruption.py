"""Signals that end the program, and what is done before it ends.

They raise no exception, which would come anywhere: within a lock, or where Python only prints it and goes on. The
program ends in their handler instead, at once, except within what must be whole.
"""

from __future__ import annotations

import os
import signal
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from types import FrameType

SIGNALS = tuple(getattr(signal, name) for name in ("SIGINT", "SIGTERM", "SIGHUP") if hasattr(signal, name))
INTERRUPTED = 130  # exit code
PATIENCE = 1  # s, with what must be whole, and with what is done at the end

Action = Callable[[], object]


class Interruption:
    """What becomes of the program when a signal asks it to end; where nobody heeds signals, nothing does."""

    def __init__(self) -> None:
        self.words = b""  # the last ones, on stderr
        self._stderr = -1
        self._actions: list[Action] = []
        self._code = 0
        self._depth = 0
        self._asked = self._ending = False

    def heed(self, exit_code: int, words: bytes) -> None:
        """From now on signals end the program with these words and this exit code, once all actions are done.

        Signals that are ignored, as in the background or under nohup, stay so.
        """
        self._code, self.words = exit_code, words
        with suppress(OSError):  # where it is closed
            self._stderr = os.dup(2)  # which stays when a simulator's own messages are silenced
        for number in SIGNALS:
            if signal.getsignal(number) is not signal.SIG_IGN:
                signal.signal(number, self._signalled)
        if hasattr(signal, "SIGALRM"):
            signal.signal(signal.SIGALRM, self._out_of_time)

    @contextmanager
    def whole(self) -> Iterator[None]:
        """What is done within is done to its end before a signal ends the program."""
        self._depth += 1
        try:
            yield
        finally:
            self._depth -= 1
            if self._asked and self._depth == 0:
                self._end()

    @contextmanager
    def at_the_end(self, action: Action) -> Iterator[None]:
        """An action is done when what is done within ends: by itself, by an exception, or with the program."""
        self._actions.append(action)
        try:
            yield
        finally:
            with self.whole():
                self._actions.remove(action)
                action()

    def _signalled(self, _number: int, _frame: FrameType | None) -> None:
        if self._depth == 0:
            self._end()
        elif not self._asked:
            self._asked = True
            _wake(PATIENCE)

    def _out_of_time(self, _number: int, _frame: FrameType | None) -> None:
        if self._ending:
            os._exit(self._code)
        self._end()

    def _end(self) -> None:
        if self._ending:  # in what a second signal came into, which goes on
            return
        self._ending = True
        _wake(PATIENCE)
        try:
            for action in (*reversed(self._actions), self._say):
                with suppress(Exception):
                    action()
        finally:
            os._exit(self._code)

    def _say(self) -> None:
        os.write(self._stderr, self.words)


def _wake(after: int) -> None:
    if hasattr(signal, "alarm"):
        signal.alarm(after)


interruption = Interruption()
