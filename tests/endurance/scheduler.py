"""A standing Dask scheduler with two workers: a worker is killed, then the scheduler."""

from __future__ import annotations

import subprocess
import sys
import time
from collections.abc import Iterable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

import psutil

from endurance.kills import Torture
from endurance.processes import GLANCE, PATIENCE, running, workers_of
from endurance.studies import GO_ON, RUN, check_complete, check_opens, demand, resume

LOCAL = ("--workers", "2")


class Standing:
    """A scheduler and its workers, which know nothing of a run until it comes."""

    def __init__(self, place: Path) -> None:
        self.file = place / "scheduler.json"
        options = ("--scheduler-file", str(self.file), "--no-dashboard", "--host", "127.0.0.1")
        self.scheduler = _begun("scheduler", "--port", "0", *options)
        self.workers = [_begun("worker", "--nthreads", "1", *options) for _ in range(2)]
        until = time.monotonic() + PATIENCE
        while not self.file.exists():
            demand(time.monotonic() < until, "there is no scheduler")
            time.sleep(GLANCE)

    def lose_worker(self, *, renewed: bool) -> None:
        """Kill a worker; one that is renewed leaves its nanny behind, which begins another."""
        nanny = self.workers[0]
        workers = workers_of(psutil.Process(nanny.pid))
        if not renewed:
            _end(nanny)
        _kill(workers)

    def end(self) -> None:
        """Leave nothing behind."""
        for process in (self.scheduler, *self.workers):
            workers = workers_of(psutil.Process(process.pid)) if process.poll() is None else []
            _end(process)
            _kill(workers)


def _begun(*words: str) -> subprocess.Popen[bytes]:
    return subprocess.Popen([sys.executable, "-m", "dask", *words], stderr=subprocess.DEVNULL)


def _kill(workers: Iterable[psutil.Process]) -> None:
    for worker in workers:
        with suppress(psutil.NoSuchProcess):
            worker.kill()


def _end(process: subprocess.Popen[bytes]) -> None:
    process.kill()
    process.wait()


@contextmanager
def standing(place: Path) -> Iterator[Standing]:
    """A cluster of two workers, as long as it is needed."""
    cluster = Standing(place)
    try:
        yield cluster
    finally:
        cluster.end()


def scheduler_killed(torture: Torture, place: Path) -> tuple[int, str]:
    """A worker is killed and the run goes on, then the scheduler, and the run says so and is resumed without Dask."""
    moments = sorted(torture.moment() for _ in range(2))
    renewed = torture.chance.random() < 0.5
    told = f"a worker{' that is renewed' if renewed else ''} {moments[0]:.2f} s after the first row"
    with standing(place) as cluster:
        engine = ("--engine", "dask", "--scheduler", str(cluster.file))
        with running(torture.study, place, engine, torture.plant) as run:
            run.wait_for_rows()
            run.goes_on_for(moments[0])
            cluster.lose_worker(renewed=renewed)
            run.goes_on_for(moments[1] - moments[0])
            known = run.rows()
            _end(cluster.scheduler)
            code, said = run.ended(), run.messages
    left = check_opens(place / RUN, known, torture.whole)
    if code == 0 and left == torture.study.trials:
        return 0, f"{told}: the same run, before the scheduler was killed"
    told += f", the scheduler {moments[1]:.2f} s: {left} kept"
    demand(code == 1, f"{told}, exit code {code}: {said}")
    for words in (
        "error[",
        "error[no-scheduler]: the Dask scheduler tcp://",
        " has gone away\n",
        f"{' '.join(GO_ON)}\n",
    ):
        demand(said.count(words) == 1, f"{told}; it does not say {words!r} once, but: {said}")
    demand("Traceback" not in said, f"{told}; {said}")
    resume(place, *LOCAL)
    check_complete(place / RUN, torture.whole)
    return 1, f"{told}; resumed: the same run"
