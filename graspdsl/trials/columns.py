"""Records as columns: an array a number, a value a trial, with its unit."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterable, Mapping, Sequence
from itertools import product
from typing import Any

import numpy as np
import numpy.typing as npt

from graspdsl.compiler.program import Program
from graspdsl.hands.descriptions import joint_units
from graspdsl.quality.grades import GRADES
from graspdsl.spec.trials import PARAMETERS
from graspdsl.trials.priorities import Disturbance, level_names
from graspdsl.trials.record import TrialRecord
from graspdsl.worlds.protocol import PARTIES

PERCENTILES = ("p50", "p95")
UNITS: Mapping[str, str] = {  # of what a record has by itself
    "number": "1",
    "rejected": "1",
    "orientation_start": "rad",
    "orientation_end": "rad",
    "force_residual_start": "1",
    "force_residual_end": "1",
    "moment_residual_start": "m",
    "moment_residual_end": "m",
    "contact_forces": "N",
    "touching": "1",
    "object_shift": "m",
    "object_lean": "rad",
    "ticks": "1",
    "ticks_to_converge": "1",
    "samples": "1",
    "point_error": "m",
    "normal_error": "rad",
    "world_s": "s",
    "wall_s": "s",
    "tare_s": "s",
}
_LOADS = {"fx": "N", "fy": "N", "fz": "N", "mx": "N·m", "my": "N·m", "mz": "N·m"}
_WORDS = ("identity", "outcome", "detail")
_COUNTS = ("number", "ticks", "samples")


@dataclasses.dataclass(frozen=True, slots=True)
class Column:
    """A value (n,) of each of n trials, or whatever else has a row, and their unit, empty for words."""

    values: npt.NDArray[Any]
    unit: str


def columns_of(program: Program, records: Sequence[TrialRecord]) -> dict[str, Column]:
    """The records of a program's trials by columns, named as in a record, in SI units; NaN where there is no number.

    What has parts has a column each: ``start.roll`` and whatever else was drawn; ``contact_forces.finger-1``, by the
    contacts that all phases control, or by their places, ``contact_forces.1``, where phases control others, and so
    ``touching``, 1 or 0; ``point_error.p50`` and ``.p95``; ``balance.contacts.fx`` to ``.mz``, and so of links, table
    and gravity; ``priorities.1.φ_f.predicted`` and ``.observed``: the largest disturbances of the level φ_f in stage 1,
    counted from 0; ``quality.force-closure.closed``, 1 or 0, and the numbers of the other grades. ``rejected`` counts
    the draws of a start that could not be taken up.
    """
    found: dict[str, Column] = {}
    for field in dataclasses.fields(TrialRecord):
        name, values = field.name, [getattr(record, field.name) for record in records]
        match name:
            case "start":
                found |= _starts(program, values)
            case "contact_forces" | "touching":
                for place, contact in enumerate(_contacts(program, values)):
                    known = (of_contacts[place] if place < len(of_contacts) else None for of_contacts in values)
                    found[f"{name}.{contact}"] = _numbers(known, UNITS[name])
            case "point_error" | "normal_error":
                for place, percentile in enumerate(PERCENTILES):
                    found[f"{name}.{percentile}"] = _numbers((pair[place] for pair in values), UNITS[name])
            case "balance":
                for party, (place, (part, unit)) in product(PARTIES, enumerate(_LOADS.items())):
                    loads = (balance and getattr(balance, party)[place] for balance in values)
                    found[f"{name}.{party}.{part}"] = _numbers(loads, unit)
            case "priorities":
                found |= _priorities(program, values)
            case "quality":
                found |= _grades(program, values)
            case "rejected":
                found[name] = Column(np.array([len(starts) for starts in values], dtype=np.int64), UNITS[name])
            case _ if name in _COUNTS:
                found[name] = Column(np.array(values, dtype=np.int64), UNITS[name])
            case _ if name in _WORDS:
                found[name] = Column(np.array([str(value) for value in values], dtype=np.str_), "")
            case _:
                found[name] = _numbers(values, UNITS[name])
    return found


def _numbers(values: Iterable[float | None], unit: str) -> Column:
    return Column(np.array([math.nan if value is None else value for value in values], dtype=float), unit)


def _starts(program: Program, starts: Sequence[Mapping[str, float]]) -> dict[str, Column]:
    units = {**joint_units(program.robot), **PARAMETERS}
    names = dict.fromkeys(name for start in starts for name in start)
    return {f"start.{name}": _numbers((start.get(name) for start in starts), units.get(name, "1")) for name in names}


def _priorities(program: Program, trials: Sequence[Sequence[Disturbance]]) -> dict[str, Column]:
    found = {}
    pipelines = [pipeline for stages in program.pipelines() for pipeline in stages]
    for stage, pipeline in enumerate(pipelines):
        for priority, level in zip(pipeline.priorities, level_names(pipeline.priorities), strict=True):
            ones = [{(one.stage, one.level): one for one in trial}.get((stage, level)) for trial in trials]
            name = f"priorities.{stage}.{level}"
            for kind, unit in (("predicted", priority.effect_unit), ("observed", priority.unit)):
                sizes = (getattr(one, kind).size if one else None for one in ones)
                found[f"{name}.{kind}"] = _numbers(sizes, unit)
    return found


def _contacts(program: Program, of_contacts: Sequence[Sequence[float]]) -> Sequence[str]:
    """What the places of numbers of contacts are called."""
    controlled = {phase.grasp.contacts for phase in program.phases}
    if len(controlled) == 1:
        return [program.robot.contacts[contact] for contact in controlled.pop()]
    return [str(place + 1) for place in range(max(map(len, of_contacts), default=0))]


def _grades(program: Program, graded: Sequence[Mapping[str, Mapping[str, Any]]]) -> dict[str, Column]:
    found = {}
    for name in program.spec.evaluate:
        grade, ones = GRADES[name], [of_trial.get(name, {}) for of_trial in graded]
        if grade.passed:
            found[f"quality.{name}.{grade.passed}"] = _numbers((one.get(grade.passed) for one in ones), "1")
        for quantity in grade.quantities:
            values = (one.get(quantity.key, {}).get("value") for one in ones)
            found[f"quality.{name}.{quantity.key}"] = _numbers(values, quantity.unit or "1")
    return found
