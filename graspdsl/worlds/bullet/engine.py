"""The only door to pybullet: imported when a bullet world is built, its banner kept off the terminal."""

from __future__ import annotations

import contextlib
import importlib
import os
import sys
from collections.abc import Iterator
from typing import Any

from graspdsl.diagnostics import Diagnostic, DiagnosticError
from graspdsl.worlds.kind import Effort

INSTALLED_BY = "pip install pybullet, which a C++ compiler builds on CPython 3.12 and later"
# At the engine's own 50 iterations friction has not converged, and what is held creeps in the hand.
EFFORT = Effort(time_step=1 / 500, solver_iterations=200)


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
    """The pybullet module, which carries no types. Raises DiagnosticError where it is not installed."""
    try:
        with silenced():
            return importlib.import_module("pybullet")
    except ModuleNotFoundError as error:
        message = "the bullet world needs PyBullet, which this Python has not"
        raise DiagnosticError([Diagnostic("engine-missing", message, hint=INSTALLED_BY)]) from error
