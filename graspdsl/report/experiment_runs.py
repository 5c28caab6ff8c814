"""A run of one of the chapter's experiments, and what of its trials the claims look at."""

from __future__ import annotations

import math
from collections.abc import Iterable
from functools import cached_property

import numpy as np

from graspdsl.arrays import Array
from graspdsl.report.evidence import Evidence, ResidualCourse
from graspdsl.report.modes import Mode, modes
from graspdsl.trials.record import TrialRecord

HUNDREDTHS, TENTHS = 0.05, 0.1  # the steps in which the chapter reads its figures: 0.45 and 1.55; 0.3, 0.8, 1 and π/2
FIXED_TIME = 20.0  # s: "approximately 1000 iterations (20 seconds)", when the chapter has residuals converged

Records = list[TrialRecord]


class ExperimentRun:
    """A run of an experiment: ``begun`` are its feasible starts, but for trials that are lost, of which nobody knows
    whether they ended in contact; ``lasts``: whether trials that no monitor stops go on
    for FIXED_TIME, which counts from where the controller takes over."""

    def __init__(self, evidence: Evidence) -> None:
        self.evidence = evidence
        self.begun = [record for record in evidence.records if record.has_begun and record.number not in evidence.lost]
        last = evidence.program.spec.program[-1]
        self.lasts = last.full_time and last.limit >= FIXED_TIME

    @property
    def name(self) -> str:
        """The experiment's."""
        return self.evidence.program.spec.name

    @cached_property
    def ends(self) -> Array:
        """The orientations [rad] at the end, whatever ended the trials."""
        return measured(self.begun, "orientation_end")

    @cached_property
    def modes(self) -> list[Mode]:
        """The modes of these."""
        return modes(self.ends)

    @cached_property
    def width(self) -> float:
        """How wide the object is where it is narrow [m]."""
        return min(self.evidence.program.body.shape.extent[:2])

    def touching(self, record: TrialRecord) -> bool:
        """Whether all contacts truly touched at the end."""
        return bool(self.evidence.touching(record))

    def near(self, place: float) -> Records:
        """Those that ended in contact and near an orientation [rad]."""
        return [
            record for record in self.begun if abs(record.orientation_end - place) <= TENTHS and self.touching(record)
        ]

    def far(self, place: float) -> Records:
        """All others."""
        near = {record.number for record in self.near(place)}
        return [record for record in self.begun if record.number not in near]

    def settled(self, records: Iterable[TrialRecord]) -> Records:
        """Those of records that no monitor stopped."""
        return [record for record in records if record.outcome.settled]

    def courses(self, records: Iterable[TrialRecord]) -> list[ResidualCourse]:
        """The residuals of records up to FIXED_TIME, of those that can be read and whose controller took over."""
        known = [self.evidence.courses.get(record.number) for record in records]
        return [course.until(FIXED_TIME) for course in known if course is not None and len(course.time)]

    def residuals(self, records: Iterable[TrialRecord]) -> tuple[Array, Array]:
        """‖ρ_f‖ (1) and ‖ρ_m‖ [m] of records at FIXED_TIME, or where a trial was stopped before: (n,) each."""
        ends = np.array([(course.force[-1], course.moment[-1]) for course in self.courses(records)]).reshape(-1, 2)
        force, moment = ends[np.isfinite(ends).all(axis=1)].T
        return force, moment

    def changes(self, records: Iterable[TrialRecord]) -> tuple[Array, Array]:
        """By how much ‖ρ_f‖ (1) and ‖ρ_m‖ [m] of records have risen by then: (n,) each."""
        courses = self.courses(records)
        risen = [(course.force[-1] - course.force[0], course.moment[-1] - course.moment[0]) for course in courses]
        changes = np.array(risen).reshape(-1, 2)
        force, moment = changes[np.isfinite(changes).all(axis=1)].T
        return force, moment


def measured(records: Iterable[TrialRecord], field: str) -> Array:
    """A number of records, where it was measured."""
    values = [getattr(record, field) for record in records]
    return np.array([value for value in values if math.isfinite(value)], dtype=float)


def largest_tilt(force: float, moment: float, diameter: float) -> float:
    """How far [rad] from perpendicular to the axis of a standing roll the line between two contacts, or between one and
    a virtual contact of two, can be, with residuals up to ‖ρ_f‖ = force < ½ and ‖ρ_m‖ = moment [m].

    A contact on a flat end leaves a vertical force of its weight, ½ or 1, so all are on the side: their normals are
    level. Let n and m be the normal and the mean normal of the two, d = |n − m|, and z their difference in height. The
    line has the slope z/(R d), and ρ_m = e × (w − ½ z (n − m)), e along the axis. w, from members at unequal heights,
    is at right angles to m, so w·(n − m) = w·ρ_f, and ‖ρ_m‖ ≥ ½ |z| d √(1 − ‖ρ_f‖²/d²). As ρ_f = n + m,
    |m| ≥ 1 − ‖ρ_f‖ and d² ≥ 2 + 2(1 − ‖ρ_f‖)² − ‖ρ_f‖².
    """
    apart = 2.0 + 2.0 * (1.0 - force) ** 2 - force**2
    return math.atan(4.0 * moment / (diameter * math.sqrt(apart * (apart - force**2))))


def moment_of_tilt(width: float) -> float:
    """‖ρ_m‖ [m] that opposed normals leave which are this far apart [m], the line between them a step of the chapter's
    reading off."""
    return width * math.tan(TENTHS)
