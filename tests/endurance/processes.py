"""Processes that are waited for, looked at and killed."""

from __future__ import annotations

import os
import signal
import sqlite3
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import closing, contextmanager, suppress
from pathlib import Path

import psutil
from cli.program import heed_interrupts
from cli.warm import PROGRAM

from endurance.studies import GO_ON, RUN, DifferenceError, Study, demand
from graspdsl.trials.store import TABLE

PATIENCE = 180.0  # s, of a machine that is busy
GLANCE = 0.01  # s
TESTS = Path(__file__).parents[1]


class Run:
    """A study that is begun in a place, or gone on with if there is some of it, in a session of its own; ``plant``: a
    mistake that the program is made to have."""

    def __init__(self, study: Study, place: Path, engine: tuple[str, ...], plant: str) -> None:
        self.table, self._messages = place / RUN / TABLE, place / "messages"
        self.before = self.rows()
        words = GO_ON if self.before else study.words()
        program = [sys.executable, "-m", "endurance.planted", plant] if plant else [str(PROGRAM)]
        surroundings = {**os.environ, "PYTHONPATH": str(TESTS)} if plant else None
        with self._messages.open("wb") as messages:
            self.process = subprocess.Popen(
                [*program, *map(str, words), *engine, "--no-report"],
                cwd=place,
                env=surroundings,
                stdout=subprocess.DEVNULL,
                stderr=messages,
                start_new_session=True,
                preexec_fn=heed_interrupts,
            )

    @property
    def messages(self) -> str:
        """What it has said on stderr."""
        return self._messages.read_text("utf-8")

    def rows(self) -> int:
        """How many trials are in its table, read while it grows."""
        with (
            suppress(sqlite3.OperationalError),  # there is none yet, or it is just being made
            closing(sqlite3.connect(f"{self.table.as_uri()}?mode=ro", uri=True)) as table,
        ):
            [(count,)] = table.execute("SELECT count(*) FROM trials")
            return count
        return 0

    def wait_for_rows(self) -> None:
        """Until its first trial is committed."""
        until = time.monotonic() + PATIENCE
        while self.rows() == self.before:
            demand(self.process.poll() is None, f"it has ended before its first trial: {self.messages}")
            demand(time.monotonic() < until, f"no trial in {PATIENCE:g} s: {self.messages}")
            time.sleep(GLANCE)

    def goes_on_for(self, time_s: float) -> bool:
        """Let it run; whether it still does."""
        with suppress(subprocess.TimeoutExpired):
            self.process.wait(time_s)
        return self.process.returncode is None

    def ended(self) -> int:
        """Its exit code, once it has ended by itself."""
        try:
            return self.process.wait(PATIENCE)
        except subprocess.TimeoutExpired:
            raise DifferenceError(f"it does not end: {self.messages}") from None

    def kill(self, *, group: bool) -> None:
        """End it at once: with all the processes that it began, or by itself, so that those have to end by
        themselves."""
        if group:
            os.killpg(self.process.pid, signal.SIGKILL)
        else:
            self.process.kill()
        self.process.wait()
        until = time.monotonic() + PATIENCE
        while left := [other for other in psutil.process_iter(["status"]) if _is_of(self.process.pid, other)]:
            demand(time.monotonic() < until, f"processes outlive it: {left}")
            time.sleep(GLANCE)

    def workers(self) -> list[psutil.Process]:
        """The processes that its trials are run in, or that will run some."""
        with suppress(psutil.Error):
            return workers_of(psutil.Process(self.process.pid))
        return []


def workers_of(process: psutil.Process) -> list[psutil.Process]:
    """Processes that Python began for this one, or for one of those."""
    found = []
    for child in process.children(recursive=True):
        with suppress(psutil.Error):
            if any("spawn_main" in word for word in child.cmdline()):
                found.append(child)
    return found


def _is_of(session: int, process: psutil.Process) -> bool:
    with suppress(ProcessLookupError):
        return process.info["status"] != psutil.STATUS_ZOMBIE and os.getsid(process.pid) == session
    return False


@contextmanager
def running(study: Study, place: Path, engine: tuple[str, ...], plant: str) -> Iterator[Run]:
    """A study from its beginning on; nothing of it is left behind."""
    run = Run(study, place, engine, plant)
    try:
        yield run
    finally:
        with suppress(ProcessLookupError):
            os.killpg(run.process.pid, signal.SIGKILL)
        run.process.wait()
