"""Which ticks of a trajectory a run keeps."""

from __future__ import annotations

import re
from typing import Annotated

import numpy as np
from pydantic import AfterValidator

from graspdsl.arrays import Rows
from graspdsl.places.fields import fault

ALL, ENDS, NONE = "all", "ends", "none"
_EVERY = re.compile(r"every=([1-9][0-9]{0,8})", re.ASCII)


def _known(keep: str) -> str:
    if keep not in (ALL, ENDS, NONE) and not _EVERY.fullmatch(keep):
        message = f"expected all, ends, none or every=N; found {keep!r}"
        raise fault("wrong-form", message, "every=10 keeps every tenth tick, and the last")
    return keep


Keep = Annotated[str, AfterValidator(_known)]


def kept(keep: str, ticks: int) -> Rows:
    """Which of so many ticks are kept: ``all``; the first and the last, the ``ends``; ``none``; ``every=N``-th from the
    first on, and the last."""
    if keep == NONE or not ticks:
        return np.zeros(0, dtype=np.intp)
    every = _EVERY.fullmatch(keep)
    step = int(every[1]) if every else 1 if keep == ALL else ticks
    found = np.arange(0, ticks, step)
    return found if found[-1] == ticks - 1 else np.append(found, ticks - 1)
