"""Runs whose processes are killed at random moments."""

from __future__ import annotations

import random
import time
from collections.abc import Callable, Iterator
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory

import psutil

from endurance.processes import GLANCE, running
from endurance.studies import RUN, Kept, Study, check_complete, check_opens, demand, kept, resume

ENGINES = {"local": ("--workers", "2"), "dask": ("--engine", "dask", "--workers", "2")}
KILLS = 3  # of workers, at most, in a run


@dataclass
class Torture:
    """A study on an engine, with what it is when nothing stops it, and how long that takes after its first trial [s]."""

    study: Study
    engine: tuple[str, ...]
    whole: Kept
    span: float
    chance: random.Random
    plant: str = ""

    def moments(self, count: int, attempt: Callable[[Torture, Path], str]) -> Iterator[str]:
        """What became of each of so many attempts; one that came too late is made again, earlier."""
        made = 0
        while made < count:
            with TemporaryDirectory(prefix="endurance-") as place:
                try:
                    told = attempt(self, Path(place))
                except TooLateError as late:
                    self.span *= 0.8
                    yield f"too late: {late}"
                else:
                    made += 1
                    yield f"{made}/{count}: {told}"


class TooLateError(Exception):
    """A run has ended before it was killed."""


def undisturbed(study: Study, engine: tuple[str, ...]) -> tuple[Kept, float]:
    """What a run is that nothing stops, and how long it takes from its first trial to its last [s]."""
    with TemporaryDirectory(prefix="endurance-") as place, running(study, Path(place), engine, "") as run:
        run.wait_for_rows()
        began = time.monotonic()
        while run.rows() < study.trials and run.goes_on_for(GLANCE):
            pass
        span = time.monotonic() - began
        demand(run.ended() == 0, f"it failed: {run.messages}")
        found = kept(Path(place) / RUN)
    demand(len(found) == study.trials, f"{len(found)} of {study.trials} trials")
    return found, span


def main_killed(torture: Torture, place: Path) -> str:
    """The process that keeps the run is killed, alone or with its workers; the run is resumed."""
    moment, group = torture.chance.uniform(0.0, torture.span), torture.chance.random() < 0.5
    with running(torture.study, place, torture.engine, torture.plant) as run:
        run.wait_for_rows()
        if not run.goes_on_for(moment):
            raise TooLateError(f"{moment:.2f} s after the first row")
        told = run.rows()
        run.kill(group=group)
    left = check_opens(place / RUN, told, torture.whole)
    resume(place, *torture.engine)
    check_complete(place / RUN, torture.whole)
    what = "all processes" if group else "the main process alone"
    return f"{what}, {moment:.2f} s after the first row: {left} of {torture.study.trials} kept, resumed to the same run"


def workers_killed(torture: Torture, place: Path) -> str:
    """Up to three workers are killed, one after the other; the run goes on."""
    count = torture.chance.randint(1, KILLS)
    moments = sorted(torture.chance.uniform(0.0, torture.span) for _ in range(count))
    killed = list[float]()
    with running(torture.study, place, torture.engine, torture.plant) as run:
        run.wait_for_rows()
        began = time.monotonic()
        for moment in moments:
            if not run.goes_on_for(max(0.0, began + moment - time.monotonic())):
                break
            if workers := run.workers():
                with suppress(psutil.NoSuchProcess):
                    torture.chance.choice(workers).kill()
                    killed.append(moment)
        demand(run.ended() == 0, f"it has ended with {run.process.returncode}: {run.messages}")
        demand("Traceback" not in run.messages, run.messages)
    if not killed:
        raise TooLateError(f"{moments[0]:.2f} s after the first row")
    named = check_complete(place / RUN, torture.whole, crashed=len(killed) - 1)
    at = ", ".join(f"{moment:.2f}" for moment in killed)
    return f"{len(killed)} workers, {at} s after the first row: " + (
        f"trials {named} crashed, all others the same" if named else "the same run"
    )
