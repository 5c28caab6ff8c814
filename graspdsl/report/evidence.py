"""What a report is made from: the records of a run, its program and the courses of its trials."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from graspdsl.arrays import Array
from graspdsl.compiler.program import Program
from graspdsl.diagnostics import DiagnosticError
from graspdsl.trials.record import TrialRecord
from graspdsl.trials.runner import program_of_run
from graspdsl.trials.store import RunFolder
from graspdsl.trials.trajectories import Layout, Rows


@dataclass(frozen=True, slots=True)
class ResidualCourse:
    """The residuals of a trial from where its controller took over, one value a tick or probe.

    time [s] since then, force ‖ρ_f‖ (1) and moment ‖ρ_m‖ [m]: (n,) each, empty where the controller never took over;
    a residual that could not be measured is the one before it. ``touching``: whether every contact of the grasp touched
    at the last row of the trial, by the simulator's truth and not as the hand senses it. ``on_top``: whether the normal
    of one was nearer to the object's axis there than at right angles to it. ``stage`` (n,) and what was seen of the
    ``disturbance`` (n, levels) of its priorities, NaN where nothing was.
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
    """A run to be reported. ``courses`` by trial number, without the trials whose trajectories cannot be read."""

    folder: RunFolder
    program: Program
    records: tuple[TrialRecord, ...]
    courses: dict[int, ResidualCourse]

    @cached_property
    def lost(self) -> frozenset[int]:
        """The numbers of trials that were measured, but whose trajectories cannot be read."""
        measured = {record.number for record in self.records if math.isfinite(record.force_residual_end)}
        return frozenset(measured - self.courses.keys())

    def touching(self, record: TrialRecord) -> bool | None:
        """Whether every contact of the grasp truly touched at the end of a trial; None where that is not known."""
        course = self.courses.get(record.number)
        return None if course is None else course.touching

    def trajectory(self, number: int) -> Rows | None:
        """The arrays of a trial, none where it had no tick; None where they cannot be read."""
        return _trajectory(self.folder, number, Layout.of(self.program))


def evidence_of(folder: RunFolder, program: Program | None = None) -> Evidence:
    """The evidence in the folder of a run; ``program``: that of the run, where it has been read already.

    Raises DiagnosticError when its records or its spec cannot be read.
    """
    program, records = program or program_of_run(folder), tuple(folder.records())
    layout, contacts = Layout.of(program), [phase.grasp.contacts for phase in program.phases]
    courses = {}
    for record in records:
        course = _course(folder, record, layout, contacts, np.array(program.body.major_axis))
        if course is not None:
            courses[record.number] = course
    return Evidence(folder, program, records, courses)


def _course(
    folder: RunFolder,
    record: TrialRecord,
    layout: Layout,
    contacts: Sequence[tuple[int, ...]],
    major_axis: Array,
) -> ResidualCourse | None:
    rows = _trajectory(folder, record.number, layout)
    if not rows:  # the trial ended before its first tick
        return None
    time, force, moment = (rows[name].astype(np.float64) for name in ("time", "force_residual", "moment_residual"))
    grasp = contacts[int(rows["phase"][-1])]
    touched = bool(np.isfinite(rows["forces"][-1, list(grasp)]).all())  # a contact that does not touch has none
    axial = np.abs(rows["normals"][-1, list(grasp)] @ (rows["object_rotation"][-1] @ major_axis))
    # The controller's samples are the last rows, from where it takes over from the guarded close.
    begun = len(time) - min(record.samples, len(time))
    return ResidualCourse(
        time[begun:] - time[begun : begun + 1],
        _held(force[begun:]),
        _held(moment[begun:]),
        touched,
        bool(axial.max(initial=0.0) > math.sqrt(0.5)),
        rows["stage"][begun:].astype(np.float64),
        rows["observed_disturbance"][begun:].astype(np.float64),
    )


def _trajectory(folder: RunFolder, number: int, layout: Layout) -> Rows | None:
    try:
        return folder.trajectory(number, layout)
    except DiagnosticError:
        return None


def _held(values: Array) -> Array:
    """The values, with the one before in place of each that is not finite; those before the first finite are its."""
    known = np.isfinite(values)
    if not known.any():
        return values
    latest = np.maximum.accumulate(np.where(known, np.arange(len(values)), -1))
    return np.asarray(values[np.where(latest < 0, int(np.argmax(known)), latest)])
