"""Local minima in a batch: the monitor of one trial's progress, for many at once."""

from __future__ import annotations

import numpy as np

from graspdsl.arrays import Array, Flags

Rows = np.ndarray[tuple[int], np.dtype[np.intp]]


class StallWatch:
    """Watches N residuals as ``Monitors.has_stalled`` watches one.

    A start has stalled when the least value of its last ``window`` steps is below that of the ``window`` before by less
    than the share ``least``. radius [m] makes moments and forces comparable.
    """

    def __init__(self, count: int, window: int, radius: float, least: float) -> None:
        self._window, self._radius = window, radius
        self._least_progress = least
        self._values = np.zeros((count, 2 * window))
        self._seen = np.zeros(count, dtype=int)

    def watch(self, step: int, rows: Rows, force: Array, moment: Array) -> Flags:
        """Which of these rows have stalled at this step; force (1), moment [m]: (n,) norms of their residuals.

        Steps are counted from 0, each row is watched in every one of its steps.
        """
        width = 2 * self._window
        self._values[rows, step % width] = np.hypot(force, moment / self._radius)
        self._seen[rows] += 1
        stalled = self._seen[rows] >= width
        full = rows[stalled]
        if len(full):
            order = (step + 1 + np.arange(width)) % width
            least = self._values[full][:, order].reshape(len(full), 2, self._window).min(axis=2)
            stalled[stalled] = least[:, 1] > (1.0 - self._least_progress) * least[:, 0]
        return stalled

    def begin_anew(self, rows: Rows) -> None:
        """Forget what was seen of these rows: they are in another stage."""
        self._seen[rows] = 0
