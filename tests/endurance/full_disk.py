"""A run on a disk that is full before it ends."""

from __future__ import annotations

import subprocess
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from endurance.kills import Torture
from endurance.processes import running
from endurance.studies import GO_ON, RUN, check_complete, check_opens, demand, resume

LEAST, MOST = 60, 900  # kB
REFUSED = "error[folder-not-writable]: cannot write to this folder: "
ROOM = 64_000  # kB


@contextmanager
def small_disk(place: Path, size: int) -> Iterator[None]:
    """A disk of so many kB in a place."""
    _mount("-t", "tmpfs", "-o", f"size={size}k", "tmpfs", place)
    try:
        yield
    finally:
        subprocess.run(["umount", place], check=True)


def _mount(*words: str | Path) -> None:
    subprocess.run(["mount", *words], check=True)


def disk_full(torture: Torture, place: Path) -> tuple[int, str]:
    """The disk is full at a random size, and later has room again."""
    size = torture.chance.randint(LEAST, MOST)
    with small_disk(place, size):
        with running(torture.study, place, torture.engine, torture.plant) as run:
            code, said = run.ended(), run.messages
        told = f"a disk of {size} kB"
        if code == 0:
            check_complete(place / RUN, torture.whole)
            return 0, f"{told}: enough"
        demand(code == 1, f"{told}: exit code {code}: {said}")
        demand("Traceback" not in said, f"{told}: {said}")
        demand(said.count("error[") == said.count(REFUSED) == 1, f"{told}: {said}")
        if not (place / RUN / "run.json").exists():
            demand(not (place / RUN).exists(), f"{told}: half a run is left")
            return 1, f"{told}: no run could be begun, and nothing is left of it"
        demand(said.endswith(f"{' '.join(GO_ON)}\n"), f"{told}: {said}")
        rows = run.rows()
        left = check_opens(place / RUN, rows, torture.whole)
        _mount("-o", f"remount,size={ROOM}k", place)
        resume(place, *torture.engine)
        check_complete(place / RUN, torture.whole)
        return 1, f"{told}: {left} kept; with room again, resumed: the same run"
