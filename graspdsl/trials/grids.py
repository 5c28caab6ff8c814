"""Maps over the starts of a hand: a run whose trials start on a grid, a trial a cell."""

from __future__ import annotations

import json
import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from pydantic import ValidationError

from graspdsl.arrays import Array
from graspdsl.compiler.program import Program
from graspdsl.diagnostics import Diagnostic, DiagnosticError, known_names_hint
from graspdsl.places.validation import slot
from graspdsl.spec.distributions import Choice, Normal, Uniform
from graspdsl.spec.models import Spec
from graspdsl.spec.trials import GridAxis, Start
from graspdsl.trials.cells import Axis, Cells
from graspdsl.trials.record import TrialRecord
from graspdsl.trials.starts import ORIENTATION, PLACEMENT

PARAMETERS = (*ORIENTATION, *PLACEMENT)


@dataclass(frozen=True, slots=True)
class WantedAxis:
    """An axis as it was asked for; without bounds, those of the spec's own distribution."""

    parameter: str
    bounds: tuple[float, float] | None
    cells: int


def refused(code: str, message: str, hint: str | None = None) -> DiagnosticError:
    """A complaint about what was asked of a map."""
    return DiagnosticError([Diagnostic(code, message, hint=hint)])


def grid_settings(program: Program, wanted: Sequence[WantedAxis]) -> tuple[str, ...]:
    """The overrides that make a program's run a map over these axes.

    All other numbers of a start stand at the middle of their distributions: the mean, or the middle one of a choice.
    Raises DiagnosticError for axes that cannot be.
    """
    start = program.spec.trials.start
    axes = [_grid_axis(start, axis) for axis in wanted]
    count = math.prod(axis.cells for axis in axes)
    fixed = [
        f"trials.start.{name}={middle(getattr(start, name))!r}"
        for name in PARAMETERS
        if name not in {axis.parameter for axis in axes} and not isinstance(getattr(start, name), float)
    ]
    return (*fixed, f"trials.grid={json.dumps([axis.model_dump() for axis in axes])}", f"trials.count={count}")


def _grid_axis(start: Start, wanted: WantedAxis) -> GridAxis:
    name = wanted.parameter
    if name not in PARAMETERS:
        hint = known_names_hint(name, PARAMETERS, "parameters of a start")
        raise refused("unknown-start-parameter", f"a start has no parameter {name!r}", hint)
    if name == "height" and start.approach == "top":
        raise refused("no-effect", "height has no effect: a hand from above has no height", "map another parameter")
    distribution = getattr(start, name)
    if wanted.bounds is None and not isinstance(distribution, Uniform):
        message = f"the spec draws no {name} between two bounds to map"
        raise refused("no-bounds", message, f"give them: --over {name}=LOW:HIGH")
    low, high = wanted.bounds or distribution.uniform
    try:
        return GridAxis.model_validate({"parameter": name, "low": low, "high": high, "cells": wanted.cells})
    except ValidationError as error:
        first = error.errors()[0]
        context, unit = first.get("ctx", {}), slot(Start, (name,)).unit
        beyond = f"{name} is mapped from {low:g} to {high:g} {unit}: {first['msg'][:1].lower()}{first['msg'][1:]}"
        hint = "angles are in radians" if unit == "rad" else "lengths are in metres"
        raise refused("out-of-range", context.get("message", beyond), context.get("hint", hint)) from None


def middle(distribution: float | Uniform | Normal | Choice) -> float:
    """The middle of a distribution: its mean, or the middle one of a choice (the lower of two)."""
    match distribution:
        case Uniform(uniform=(low, high)):
            return 0.5 * (low + high)
        case Normal(normal=(mean, _)):
            return mean
        case Choice(choice=values):
            return sorted(values)[(len(values) - 1) // 2]
    return float(distribution)


def axes_of(spec: Spec) -> tuple[Axis, Axis]:
    """The axes of the map that a spec's run is. Raises DiagnosticError when it is none."""
    grid = spec.trials.grid or ()
    if len(grid) != 2 or spec.trials.count != math.prod(axis.cells for axis in grid):
        raise refused("not-a-map", "this run is no map", "give the folder that 'graspdsl map' made")
    x, y = (
        Axis(axis.parameter, slot(Start, (axis.parameter,)).unit or "", axis.low, axis.high, axis.cells)
        for axis in grid
    )
    return x, y


def cells_of(spec: Spec, records: Sequence[TrialRecord]) -> Cells:
    """The map of a finished run on a grid, its records by number. Raises DiagnosticError for a run that is none."""
    x, y = axes_of(spec)
    fixed = {
        name: f"{value:g} {slot(Start, (name,)).unit}"
        for name in PARAMETERS
        if name not in (x.parameter, y.parameter)
        and isinstance(value := getattr(spec.trials.start, name), float)  # and not drawn for each trial
    }
    return Cells(
        x=x,
        y=y,
        outcomes=tuple(record.outcome.value for record in records),
        orientation=np.array([record.orientation_end for record in records]),
        ticks=_ticks(records),
        fixed=fixed,
        marks={},
        details=tuple(record.detail for record in records),
    )


def _ticks(records: Sequence[TrialRecord]) -> Array:
    found = [record.ticks_to_converge for record in records]
    return np.array([math.nan if ticks is None else float(ticks) for ticks in found])
