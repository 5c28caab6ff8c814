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
KILLS = 4  # of a run, at most


@dataclass
class Torture:
    """A study on an engine, with what it is when nothing stops it, and how long it then takes from its first trial to
    its last [s]."""

    study: Study
    engine: tuple[str, ...]
    whole: Kept
    span: float
    chance: random.Random
    plant: str = ""

    def moment(self) -> float:
        """A random one, after the first trial [s]."""
        return self.chance.uniform(0.0, self.span)

    def killed(self, count: int, attempt: Callable[[Torture, Path], tuple[int, str]]) -> Iterator[str]:
        """What became of each attempt, until so many kills have been made in all."""
        made = 0
        while made < count:
            with TemporaryDirectory(prefix="endurance-") as place:
                kills, told = attempt(self, Path(place))
            made += kills
            self.span *= 1.0 if kills else 0.8  # all came too late
            yield f"{made}/{count}: {told}"


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


def main_killed(torture: Torture, place: Path) -> tuple[int, str]:
    """The process that keeps the run is killed, alone or with its workers; the run is gone on with, and that is killed,
    and so on; at last it is finished."""
    told = list[str]()
    for _ in range(torture.chance.randint(1, KILLS)):
        moment, group = torture.moment(), torture.chance.random() < 0.5
        with running(torture.study, place, torture.engine, torture.plant) as run:
            run.wait_for_rows()
            if not run.goes_on_for(moment):
                break
            known = run.rows()
            run.kill(group=group)
        left = check_opens(place / RUN, known, torture.whole)
        told.append(f"{'all' if group else 'main'} {moment:.2f} s after a first row, {left} kept")
        if left == torture.study.trials:
            break
    resume(place, *torture.engine)
    check_complete(place / RUN, torture.whole)
    return len(told), "; ".join([*told, "resumed: the same run"])


def workers_killed(torture: Torture, place: Path) -> tuple[int, str]:
    """Workers are killed, one after the other; the run goes on."""
    moments = sorted(torture.moment() for _ in range(torture.chance.randint(1, KILLS)))
    killed = list[float]()
    with running(torture.study, place, torture.engine, torture.plant) as run:
        run.wait_for_rows()
        began = time.monotonic()
        for moment in moments:
            if not run.goes_on_for(max(0.0, began + moment - time.monotonic())) or run.rows() == torture.study.trials:
                break
            if workers := run.workers():
                with suppress(psutil.NoSuchProcess):
                    torture.chance.choice(workers).kill()
                    killed.append(moment)
        demand(run.ended() == 0, f"it has ended with {run.process.returncode}: {run.messages}")
        demand("Traceback" not in run.messages, run.messages)
    named = check_complete(place / RUN, torture.whole, crashed=max(0, len(killed) - 1))
    at = ", ".join(f"{moment:.2f}" for moment in killed)
    same = f"trials {named} named as crashed, all others the same" if named else "the same run"
    return len(killed), f"a worker {at} s after the first row: {same}" if killed else f"too late: {same}"
