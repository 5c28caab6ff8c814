"""A standing Dask scheduler with two workers: a worker is killed, then the scheduler."""

from __future__ import annotations

import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

import psutil

from endurance.kills import TooLateError, Torture
from endurance.processes import GLANCE, PATIENCE, running, workers_of
from endurance.studies import RUN, check_complete, check_opens, demand, resume

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
        nanny = self.workers.pop()
        workers = workers_of(psutil.Process(nanny.pid))
        if not renewed:
            _end(nanny)
        for worker in workers:
            with suppress(psutil.NoSuchProcess):
                worker.kill()

    def end(self) -> None:
        """Leave nothing behind."""
        for process in (self.scheduler, *self.workers):
            for worker in workers_of(psutil.Process(process.pid)) if process.poll() is None else ():
                with suppress(psutil.NoSuchProcess):
                    worker.kill()
            _end(process)


def _begun(*words: str) -> subprocess.Popen[bytes]:
    return subprocess.Popen([sys.executable, "-m", "dask", *words], stderr=subprocess.DEVNULL)


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


def scheduler_killed(torture: Torture, place: Path) -> str:
    """A worker is killed and the run goes on, then the scheduler, and the run says so and is resumed without Dask."""
    moments = sorted(torture.chance.uniform(0.0, torture.span) for _ in range(2))
    renewed = torture.chance.random() < 0.5
    with standing(place) as cluster:
        engine = ("--engine", "dask", "--scheduler", str(cluster.file))
        with running(torture.study, place, engine, torture.plant) as run:
            run.wait_for_rows()
            if not run.goes_on_for(moments[0]):
                raise TooLateError(f"{moments[0]:.2f} s after the first row")
            cluster.lose_worker(renewed=renewed)
            if not run.goes_on_for(moments[1] - moments[0]):
                raise TooLateError(f"{moments[1]:.2f} s after the first row")
            told = run.rows()
            _end(cluster.scheduler)
            code = run.ended()
            said = run.messages
    how = f"a worker{' that is renewed' if renewed else ''} and the scheduler, "
    how += f"{moments[0]:.2f} and {moments[1]:.2f} s after the first row: "
    if code == 0:
        check_complete(place / RUN, torture.whole)
        raise TooLateError(f"the scheduler, {moments[1]:.2f} s after the first row")
    demand(code == 1, f"{how}exit code {code}: {said}")
    for words in ("error[no-scheduler]: the Dask scheduler tcp://", " has gone away\n", "graspdsl run --resume run\n"):
        demand(said.count(words) == 1, f"{how}it does not say {words!r} once, but: {said}")
    demand(said.count("error[") == 1, f"{how}{said}")
    demand("Traceback" not in said, f"{how}{said}")
    left = check_opens(place / RUN, told, torture.whole)
    resume(place, *LOCAL)
    check_complete(place / RUN, torture.whole)
    return f"{how}{left} of {torture.study.trials} kept, resumed to the same run"
