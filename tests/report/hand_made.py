"""Evidence made by hand: trials of the chapter's experiments that ended as a test says."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import numpy as np

from graspdsl.compiler.program import Program, program_of
from graspdsl.report.evidence import Evidence, ResidualCourse
from graspdsl.trials.outcomes import OUTCOMES, Outcome
from graspdsl.trials.record import TrialRecord
from graspdsl.trials.store import Manifest, RunFolder

SPECS = Path(__file__).parents[2] / "specs" / "experiments"


@dataclass(frozen=True)
class HandMade:
    """A trial: orientations [rad], residuals at the end, ticks to converge, courses of the residuals (from 1 to their
    end, if not given), contact at the end, whether a finger is on the top, and whether a monitor stopped it."""

    end: float = 1.56
    start: float = 1.0
    force: float = 0.02
    moment: float = 0.002  # m
    ticks: int | None = 200
    forces: Sequence[float] = ()
    moments: Sequence[float] = ()
    touching: bool = True
    on_top: bool = False
    stopped: bool = False


def evidence(experiment: int, trials: Sequence[HandMade], *overrides: str) -> Evidence:
    """A run of an experiment of the chapter, by its number, with these trials."""
    program = _program(experiment, overrides)
    manifest = Manifest("by-hand", "spec.yaml", (), 1, len(trials), {"graspdsl": "0"})
    records = tuple(_record(number, trial) for number, trial in enumerate(trials))
    courses = {number: _course(trial) for number, trial in enumerate(trials)}
    return Evidence(RunFolder(Path("by-hand"), manifest), program, records, courses, frozenset())


@cache
def _program(experiment: int, overrides: tuple[str, ...]) -> Program:
    [spec] = SPECS.glob(f"{experiment}_*.yaml")
    return program_of(spec.read_text("utf-8"), spec.name, overrides)


def _course(trial: HandMade) -> ResidualCourse:
    force, moment = np.array(trial.forces or (1.0, trial.force)), np.array(trial.moments or (1.0, trial.moment))
    return ResidualCourse(np.arange(len(force)) / 50.0, force, moment, trial.on_top)


def _outcome(trial: HandMade) -> Outcome:
    if trial.stopped:
        return OUTCOMES["palm-collision"]
    return Outcome.TIMEOUT if trial.ticks is None else Outcome.CONVERGED


def _record(number: int, trial: HandMade) -> TrialRecord:
    nothing = {name: math.nan for name, kind in TrialRecord.__annotations__.items() if kind == "float"}
    made = {
        "number": number,
        "identity": "x",
        "outcome": _outcome(trial),
        "detail": "",
        "start": {},
        "rejected": (),
        "orientation_start": trial.start,
        "orientation_end": trial.end,
        "force_residual_end": trial.force,
        "moment_residual_end": trial.moment,
        "contact_forces": (0.5, 0.5, 0.5),
        "touching": () if math.isnan(trial.force) else (True, True, trial.touching),
        "ticks": max(1, len(trial.forces) - 1),
        "ticks_to_converge": trial.ticks,
        "samples": max(2, len(trial.forces)),
        "point_error": (math.nan, math.nan),
        "normal_error": (math.nan, math.nan),
        "world_s": 1.0,
    }
    return TrialRecord(**{**nothing, **made})
