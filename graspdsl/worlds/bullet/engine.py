"""The only door to pybullet: imported when a bullet world is built, its banner kept off the terminal."""

from __future__ import annotations

import contextlib
import importlib
import os
import sys
from collections.abc import Iterator
from typing import Any

CONTROL_RATE = 50.0  # Hz, of ticks
TIME_STEP = 1 / 500  # s, of physics


@contextlib.contextmanager
def silenced() -> Iterator[None]:
    """Send what C code writes to the standard output and error files to nowhere for a moment."""
    sys.stdout.flush()
    sys.stderr.flush()
    saved = [(fd, os.dup(fd)) for fd in (1, 2)]
    nowhere = os.open(os.devnull, os.O_WRONLY)
    try:
        for fd, _ in saved:
            os.dup2(nowhere, fd)
        yield
    finally:
        for fd, copy in saved:
            os.dup2(copy, fd)
            os.close(copy)
        os.close(nowhere)


def pybullet() -> Any:
    """The pybullet module, which carries no types."""
    with silenced():
        return importlib.import_module("pybullet")
