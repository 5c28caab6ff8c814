"""What a report is made from: the records of a run, its program and the courses of its trials."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from graspdsl.arrays import Array
from graspdsl.compiler.program import Program
from graspdsl.diagnostics import DiagnosticError
from graspdsl.trials.record import TrialRecord
from graspdsl.trials.runner import program_of_run
from graspdsl.trials.store import RunFolder
from graspdsl.trials.trajectories import Layout


@dataclass(frozen=True, slots=True)
class ResidualCourse:
    """The residuals of a trial from where its controller took over, one value a tick or probe.

    time [s] since then, force ‖ρ_f‖ (1) and moment ‖ρ_m‖ [m]: (n,) each, empty where the controller never took over;
    a residual that could not be measured is the one before it. ``touching``: whether every contact of the grasp touched
    at the last row of the trial, by the simulator's truth and not as the hand senses it.
    """

    time: Array
    force: Array
    moment: Array
    touching: bool


@dataclass(frozen=True, slots=True)
class Evidence:
    """A run to be reported. ``courses`` by trial number, without the trials whose trajectories cannot be read."""

    folder: RunFolder
    program: Program
    records: tuple[TrialRecord, ...]
    courses: dict[int, ResidualCourse]

    def touching(self, record: TrialRecord) -> bool | None:
        """Whether every contact of the grasp truly touched at the end of a trial; None where that is not known."""
        course = self.courses.get(record.number)
        return None if course is None else course.touching


def evidence_of(folder: RunFolder, program: Program | None = None) -> Evidence:
    """The evidence in the folder of a run; ``program``: that of the run, where it has been read already.

    Raises DiagnosticError when its records or its spec cannot be read.
    """
    program, records = program or program_of_run(folder), tuple(folder.records())
    layout, contacts = Layout.of(program), [phase.grasp.contacts for phase in program.phases]
    courses = {}
    for record in records:
        course = _course(folder, record, layout, contacts)
        if course is not None:
            courses[record.number] = course
    return Evidence(folder, program, records, courses)


def _course(
    folder: RunFolder, record: TrialRecord, layout: Layout, contacts: Sequence[tuple[int, ...]]
) -> ResidualCourse | None:
    try:
        rows = folder.trajectory(record.number, layout)
    except DiagnosticError:
        return None
    if not rows:  # the trial ended before its first tick
        return None
    time, force, moment = (rows[name].astype(np.float64) for name in ("time", "force_residual", "moment_residual"))
    grasp = contacts[int(rows["phase"][-1])]
    touched = bool(np.isfinite(rows["forces"][-1, list(grasp)]).all())  # a contact that does not touch has none
    # The controller's samples are the last rows, from where it takes over from the guarded close.
    begun = len(time) - min(record.samples, len(time))
    return ResidualCourse(time[begun:] - time[begun : begun + 1], _held(force[begun:]), _held(moment[begun:]), touched)


def _held(values: Array) -> Array:
    """The values, with the one before in place of each that is not finite; those before the first finite are its."""
    known = np.isfinite(values)
    if not known.any():
        return values
    latest = np.maximum.accumulate(np.where(known, np.arange(len(values)), -1))
    return np.asarray(values[np.where(latest < 0, int(np.argmax(known)), latest)])
