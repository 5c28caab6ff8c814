"""What is compared of two runs: one line a measure."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from graspdsl.arrays import Array
from graspdsl.trials.outcomes import Outcome
from graspdsl.trials.record import TrialRecord


@dataclass(frozen=True, slots=True)
class Measure:
    """A number of a trial: ``of`` takes it from the record, NaN where it was not measured.

    ``digits`` after the point where it is shown. ``every``: of every finished trial, else only of converged ones.
    ``ratio``: whether it is a cost, which is compared by ratio as well.
    """

    label: str
    digits: int
    of: Callable[[TrialRecord], float]
    every: bool = True
    ratio: bool = False

    def counts(self, record: TrialRecord) -> bool:
        """Whether a trial has this measure."""
        return (self.every or record.outcome is Outcome.CONVERGED) and math.isfinite(self.of(record))

    def values(self, records: Sequence[TrialRecord]) -> Array:
        """The measure of the trials that have it."""
        return np.array([self.of(record) for record in records if self.counts(record)], dtype=float)

    def paired(self, pairs: Sequence[tuple[TrialRecord, TrialRecord]]) -> tuple[Array, Array]:
        """The measure of both trials of the pairs in which both have it."""
        both = [pair for pair in pairs if self.counts(pair[0]) and self.counts(pair[1])]
        rows = np.array([[self.of(a), self.of(b)] for a, b in both], dtype=float).reshape(-1, 2)
        return rows[:, 0], rows[:, 1]


MEASURES: Mapping[str, Measure] = {
    "world_s": Measure("time of a trial [s] *", 2, lambda r: r.world_s, every=False, ratio=True),
    "samples": Measure("tactile samples *", 0, lambda r: float(r.samples), every=False, ratio=True),
    "ticks": Measure("ticks or probes *", 0, lambda r: float(r.ticks), every=False, ratio=True),
    "orientation_end": Measure("orientation at the end [rad]", 3, lambda r: r.orientation_end),
    "force_residual_end": Measure("force residual at the end", 4, lambda r: r.force_residual_end),
    "moment_residual_end": Measure("moment residual at the end [m]", 5, lambda r: r.moment_residual_end),
    "object_shift": Measure("object moved [m]", 5, lambda r: r.object_shift),
    "point_error": Measure("error of sensed points, 95th percentile [m]", 5, lambda r: r.point_error[1]),
    "normal_error": Measure("error of sensed normals, 95th percentile [rad]", 3, lambda r: r.normal_error[1]),
}
