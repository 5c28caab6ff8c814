"""The program with a mistake, which has to be found: ``python -m endurance.planted MISTAKE WORD …``."""

from __future__ import annotations

import dataclasses
import math
import sys
import time
import zlib
from collections.abc import Callable

from graspdsl.cli import main
from graspdsl.trials import workers
from graspdsl.trials.packs import Packs, Piece
from graspdsl.trials.record import PackedTrial
from graspdsl.trials.store import RunFolder

_add, _put = RunFolder.add, Packs.put


def _row_first() -> None:
    """The row of a trial is committed, and then its trajectory put where the row says."""
    waiting: list[tuple[Packs, int, bytes]] = []

    def place(packs: Packs, number: int, content: bytes) -> Piece:
        waiting.append((packs, number, content))
        file = packs.file(number)
        return Piece(number, file.stat().st_size if file.exists() else 0, len(content), zlib.crc32(content))

    def add(folder: RunFolder, trial: PackedTrial) -> None:
        _add(folder, trial)
        time.sleep(0.005)
        _put(*waiting.pop())

    Packs.put, RunFolder.add = place, add


def _last_bit() -> None:
    """A residual of every seventh trial is the next number."""

    def add(folder: RunFolder, trial: PackedTrial) -> None:
        if trial.record.number % 7 == 3:
            residual = math.nextafter(trial.record.force_residual_end, math.inf)
            trial = dataclasses.replace(trial, record=dataclasses.replace(trial.record, force_residual_end=residual))
        _add(folder, trial)

    RunFolder.add = add


def _other_trajectory() -> None:
    """Every trial is kept with the trajectory of the one that ended before it."""
    before: list[bytes] = []

    def add(folder: RunFolder, trial: PackedTrial) -> None:
        before.append(trial.trajectory)
        _add(folder, dataclasses.replace(trial, trajectory=before[-2:][0]))

    RunFolder.add = add


def _one_try() -> None:
    """A trial whose worker ends is not run again."""
    workers.RUNS = 1


MISTAKES: dict[str, Callable[[], None]] = {
    "row-first": _row_first,
    "last-bit": _last_bit,
    "other-trajectory": _other_trajectory,
    "one-try": _one_try,
}


if __name__ == "__main__":
    MISTAKES[sys.argv.pop(1)]()
    sys.argv[0] = "graspdsl"
    main()
