"""A monitor: a moment residual that rises again after it had fallen."""

from __future__ import annotations

import numpy as np

from graspdsl.arrays import Flags, Rows
from graspdsl.spec.outcomes import STROKES, Outcome
from graspdsl.spec.watching import Distance, Monitor, Setting, Sight


class ReboundMonitor(Monitor):
    """A moment residual above its least of the stage: the controller gives up again what it had reached."""

    key = "rebound"
    description = "the moment residual has risen by more than this (m) above its least of the stage: rebounded"
    bound_type, default = Distance, 0.03
    outcome = Outcome("rebounded", "the moment residual rose again after it had fallen", "#8f98a2", STROKES)

    def __init__(self, bound: float, setting: Setting) -> None:
        super().__init__(bound, setting)
        self._least = np.full(len(setting.began), np.inf)

    def speaks(self, sight: Sight) -> Flags:
        """Trials whose moment residual has risen by more than the bound, (M,)."""
        rows = sight.rows
        self._least[rows] = np.minimum(self._least[rows], sight.moment_residual)
        return np.asarray(sight.moment_residual - self._least[rows] > self.bound)

    def detail(self, sight: Sight, place: int) -> str:
        """By how much."""
        rise = sight.moment_residual[place] - self._least[sight.rows[place]]
        return f"the moment residual rose by {1000.0 * rise:.0f} mm"

    def begin_anew(self, rows: Rows) -> None:
        """Another stage has a least of its own."""
        self._least[rows] = np.inf
