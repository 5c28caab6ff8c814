"""What a report is made from: the records of a run, its program and the courses of its trials."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace

import numpy as np

from graspdsl.arrays import Array
from graspdsl.compiler.program import Program
from graspdsl.diagnostics import DiagnosticError
from graspdsl.spec.keeping import ENDS, NONE
from graspdsl.trials.packs import Piece, absent
from graspdsl.trials.record import TrialRecord
from graspdsl.trials.runner import program_of_run
from graspdsl.trials.store import RunFolder
from graspdsl.trials.trajectories import TICK, Layout, Rows

MOST_COURSES = 2000  # which bounds the memory of a report


@dataclass(frozen=True, slots=True)
class ResidualCourse:
    """The residuals of a trial from where its controller took over, one value a tick or probe.

    time [s] since then, force ‖ρ_f‖ (1) and moment ‖ρ_m‖ [m]: (n,) each, empty where the controller never took over,
    of a trajectory of which the ends alone are kept, and of all but MOST_COURSES trials, spread evenly over a run. A
    residual that could not be measured, or was not kept, is the one before it. ``touching``: whether every contact of
    the grasp touched at the last row of the trial, by the simulator's truth and not as the hand senses it. ``on_top``:
    whether the normal of one was nearer to the object's axis there than at right angles to it. ``stage`` (n,) and what
    was seen of the ``disturbance`` (n, levels) of its priorities, NaN where nothing was.
    """

    time: Array
    force: Array
    moment: Array
    touching: bool
    on_top: bool = False
    stage: Array = field(default_factory=lambda: np.zeros(0))
    disturbance: Array = field(default_factory=lambda: np.zeros((0, 0)))

    def until(self, seconds: float) -> ResidualCourse:
        """The course up to a time [s], with a value then where the trial went on."""
        rows = int(np.searchsorted(self.time, seconds + 1e-6, side="right"))
        return replace(self, time=self.time[:rows], force=self.force[:rows], moment=self.moment[:rows])

    def disturbed(self, stage: int, place: int) -> Array:
        """The disturbance (n,) of a level of a stage, NaN in others."""
        if place >= self.disturbance.shape[1]:
            return np.full(len(self.stage), np.nan)
        return np.where(self.stage == stage, self.disturbance[:, place], np.nan)


@dataclass(frozen=True)
class Evidence:
    """A run to be reported. ``courses`` by trial number, without those that were not kept or are ``lost``: trials that
    were measured, but whose trajectories cannot be read."""

    folder: RunFolder
    program: Program
    records: tuple[TrialRecord, ...]
    courses: dict[int, ResidualCourse]
    lost: frozenset[int]
    pieces: Mapping[int, Piece] = field(default_factory=dict)  # where trajectories are, by trial

    def touching(self, record: TrialRecord) -> bool | None:
        """Whether every contact of the grasp truly touched at the end of a trial; None where that is not known."""
        course = self.courses.get(record.number)
        return None if course is None else course.touching

    def trajectory(self, number: int) -> Rows | None:
        """The arrays of a trial, none where it had no tick; None where they were not kept or cannot be read."""
        if self.program.spec.trials.keep == NONE:
            return None
        try:
            return self.folder.unpacked(self.pieces.get(number, absent(number)), Layout.of(self.program))
        except DiagnosticError:
            return None


def evidence_of(
    folder: RunFolder, program: Program | None = None, records: Iterable[TrialRecord] | None = None
) -> Evidence:
    """The evidence in the folder of a run; ``program``, ``records``: those of the run, where they have been read.

    Raises DiagnosticError when its records or its spec cannot be read.
    """
    program, records = program or program_of_run(folder), tuple(folder.records() if records is None else records)
    read, pieces = _CourseReader(program), {piece.number: piece for piece in folder.pieces()}
    layout, each = Layout.of(program), math.ceil(len(records) / MOST_COURSES)
    courses, lost = dict[int, ResidualCourse](), set[int]()
    for place, record in enumerate(records):
        try:
            rows = folder.unpacked(pieces.get(record.number, absent(record.number)), layout)
        except DiagnosticError:
            lost |= {record.number} if math.isfinite(record.force_residual_end) else set()
            continue
        if rows:  # the trial had a tick
            courses[record.number] = read(record, rows, curves=place % each == 0)
    return Evidence(folder, program, records, courses, frozenset(lost), pieces)


class _CourseReader:
    def __init__(self, program: Program) -> None:
        self._contacts = [list(phase.grasp.contacts) for phase in program.phases]
        self._major_axis = np.array(program.body.major_axis)
        self._curves = program.spec.trials.keep != ENDS

    def __call__(self, record: TrialRecord, rows: Rows, *, curves: bool) -> ResidualCourse:
        grasp = self._contacts[int(rows["phase"][-1])]
        touched = bool(np.isfinite(rows["forces"][-1, grasp]).all())  # a contact that does not touch has none
        axial = np.abs(rows["normals"][-1, grasp] @ (rows["object_rotation"][-1] @ self._major_axis))
        # The controller's samples are the last ticks, from where it takes over from the guarded close.
        ticks = rows[TICK].astype(np.intp)
        count = int(ticks[-1]) + 1
        begun = count - min(record.samples, count) if curves and self._curves else count
        kept = np.searchsorted(ticks, np.arange(begun, count), side="right") - 1
        time, force, moment, stage, disturbance = (rows[name][kept].astype(np.float64) for name in _CURVES)
        on_top = bool(axial.max(initial=0.0) > math.sqrt(0.5))
        return ResidualCourse(time - time[:1], _held(force), _held(moment), touched, on_top, stage, disturbance)


_CURVES = "time", "force_residual", "moment_residual", "stage", "observed_disturbance"


def _held(values: Array) -> Array:
    """The values, with the one before in place of each that is not finite; those before the first finite are its."""
    known = np.isfinite(values)
    if not known.any():
        return values
    latest = np.maximum.accumulate(np.where(known, np.arange(len(values)), -1))
    return np.asarray(values[np.where(latest < 0, int(np.argmax(known)), latest)])
