"""What a report is made from: the records of a run, its program and the courses of its trials."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping
from contextlib import suppress
from dataclasses import dataclass, field, replace
from functools import cached_property

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
    or of a trajectory of which the ends alone are kept. A residual that could not be measured, or was not kept, is the
    one before it. ``on_top``: whether the normal of a contact of the grasp was nearer to the object's axis at the last
    row than at right angles to it. ``stage`` (n,) and what was seen of the ``disturbance`` (n, levels) of its
    priorities, NaN where nothing was.
    """

    time: Array
    force: Array
    moment: Array
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
    """A run to be reported. ``lost``: trials that were measured, but whose trajectories are not as they were written.
    ``courses`` by trial number, of at most MOST_COURSES trials, spread evenly over a run, without those that were not
    kept or are lost."""

    folder: RunFolder
    program: Program
    records: tuple[TrialRecord, ...]
    courses: Mapping[int, ResidualCourse]
    lost: frozenset[int]
    pieces: Mapping[int, Piece] = field(default_factory=dict)  # where trajectories are, by trial

    def touching(self, record: TrialRecord) -> bool | None:
        """Whether every contact of the grasp truly touched at the end of a trial; None where that is not known."""
        return None if record.number in self.lost else record.in_contact

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
    found = folder.pieces()
    whole, pieces = folder.packs.whole(found), {piece.number: piece for piece in found}
    measured = (record.number for record in records if math.isfinite(record.force_residual_end))
    courses = _Courses(folder, program, records[:: math.ceil(len(records) / MOST_COURSES) or 1], pieces)
    return Evidence(folder, program, records, courses, frozenset(measured) - whole, pieces)


class _Courses(Mapping[int, ResidualCourse]):
    """The courses of trials, read once one of them is wanted, for what is said of a run can mostly do without."""

    def __init__(
        self, folder: RunFolder, program: Program, records: Iterable[TrialRecord], pieces: Mapping[int, Piece]
    ) -> None:
        self._folder, self._program, self._records, self._pieces = folder, program, records, pieces

    def __getitem__(self, number: int) -> ResidualCourse:
        return self._read[number]

    def __iter__(self) -> Iterator[int]:
        return iter(self._read)

    def __len__(self) -> int:
        return len(self._read)

    @cached_property
    def _read(self) -> dict[int, ResidualCourse]:
        reader, layout, courses = _CourseReader(self._program), Layout.of(self._program), dict[int, ResidualCourse]()
        for record in self._records:
            with suppress(DiagnosticError):
                rows = self._folder.unpacked(self._pieces.get(record.number, absent(record.number)), layout)
                if rows:  # the trial had a tick
                    courses[record.number] = reader(record, rows)
        return courses


class _CourseReader:
    def __init__(self, program: Program) -> None:
        self._contacts = [list(phase.grasp.contacts) for phase in program.phases]
        self._major_axis = np.array(program.body.major_axis)
        self._curves = program.spec.trials.keep != ENDS

    def __call__(self, record: TrialRecord, rows: Rows) -> ResidualCourse:
        grasp = self._contacts[int(rows["phase"][-1])]
        axial = np.abs(rows["normals"][-1, grasp] @ (rows["object_rotation"][-1] @ self._major_axis))
        # The controller's samples are the last ticks, from where it takes over from the guarded close.
        ticks = rows[TICK].astype(np.intp)
        count = int(ticks[-1]) + 1
        begun = count - min(record.samples, count) if self._curves else count
        kept = np.searchsorted(ticks, np.arange(begun, count), side="right") - 1
        time, force, moment, stage, disturbance = (rows[name][kept].astype(np.float64) for name in _CURVES)
        on_top = bool(axial.max(initial=0.0) > math.sqrt(0.5))
        return ResidualCourse(time - time[:1], _held(force), _held(moment), on_top, stage, disturbance)


_CURVES = "time", "force_residual", "moment_residual", "stage", "observed_disturbance"


def _held(values: Array) -> Array:
    """The values, with the one before in place of each that is not finite; those before the first finite are its."""
    known = np.isfinite(values)
    if not known.any():
        return values
    latest = np.maximum.accumulate(np.where(known, np.arange(len(values)), -1))
    return np.asarray(values[np.where(latest < 0, int(np.argmax(known)), latest)])
