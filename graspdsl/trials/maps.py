"""Maps of the domain of attraction: what becomes of starts on a grid of two axes.

Of a hand it is a run whose trials start on the grid, a trial a cell; of floating contacts one of them starts in each
direction of it, and nothing is kept but the map.
"""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from pydantic import ValidationError

from graspdsl.arrays import Array
from graspdsl.basis.resources import ContactSet
from graspdsl.compiler.program import Program
from graspdsl.diagnostics import Diagnostic, DiagnosticError, known_names_hint
from graspdsl.objects.surfaces.compiled import compiled
from graspdsl.objects.surfaces.surface import Surface
from graspdsl.places.validation import slot
from graspdsl.spec.distributions import Choice, Normal, Uniform
from graspdsl.spec.models import Spec
from graspdsl.spec.trials import GridAxis, StartSettings
from graspdsl.trials.course import Course
from graspdsl.trials.measures import orientation
from graspdsl.trials.outcomes import Outcome
from graspdsl.trials.record import TrialRecord
from graspdsl.trials.side_by_side import SideBySide, over
from graspdsl.trials.stages import stages_of
from graspdsl.trials.starts import ORIENTATION, PLACEMENT, generator
from graspdsl.worlds.floating import Floating, FloatingWorld
from graspdsl.worlds.protocol import Truth

PARAMETERS = (*ORIENTATION, *PLACEMENT)
TOGETHER = 2000  # cells of floating contacts side by side, which bounds the memory
WHOLE = {"azimuth": (-math.pi, math.pi), "polar": (0.0, math.pi)}  # rad
ALLOWED = {"azimuth": (-2 * math.pi, 2 * math.pi), "polar": (0.0, math.pi)}  # rad
AS_TYPED = 1e-3  # rad, by which a rounded π may miss
ALONG_RAY = 256  # points looked at
HALVINGS = 60


@dataclass(frozen=True, slots=True)
class Axis:
    """An axis of a map: equal cells of a parameter from low to high, in its unit."""

    parameter: str
    unit: str
    low: float
    high: float
    cells: int

    @property
    def edges(self) -> Array:
        """The parameter where cells begin and end, (cells + 1,)."""
        return np.linspace(self.low, self.high, self.cells + 1)

    @property
    def middles(self) -> Array:
        """The parameter at the middle of each cell, (cells,)."""
        return self.low + (np.arange(self.cells) + 0.5) * (self.high - self.low) / self.cells

    @property
    def said(self) -> str:
        """The axis as ``--over`` takes it."""
        return f"{self.parameter}={self.low!r}:{self.high!r}"


@dataclass(frozen=True, slots=True)
class Cells:
    """A map of n = columns × rows cells, the columns of the first row first.

    outcomes: (n,) by name; orientation [rad] and ticks: (n,), of the grasp at the end and to converge, NaN where there
    is none; details: (n,) what was said of each, maybe nothing. ``x`` and ``y``: the axes of columns and rows.
    ``fixed``: what all starts have in common, in words and with its value; ``marks``: places on the map to show, by
    name.
    """

    x: Axis
    y: Axis
    outcomes: tuple[str, ...]
    orientation: Array
    ticks: Array
    fixed: Mapping[str, str]
    marks: Mapping[str, tuple[float, float]]
    details: tuple[str, ...]


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


def _grid_axis(start: StartSettings, wanted: WantedAxis) -> GridAxis:
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
        context, unit = first.get("ctx", {}), slot(StartSettings, (name,)).unit
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
        Axis(axis.parameter, slot(StartSettings, (axis.parameter,)).unit or "", axis.low, axis.high, axis.cells)
        for axis in grid
    )
    return x, y


def cells_of(spec: Spec, records: Sequence[TrialRecord]) -> Cells:
    """The map of a finished run on a grid, its records by number. Raises DiagnosticError for a run that is none."""
    x, y = axes_of(spec)
    fixed = {
        name: f"{value:g} {slot(StartSettings, (name,)).unit}"
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


# Floating contacts


def floating_cells(
    program: Program,
    wanted: Sequence[WantedAxis],
    contact: str | None,
    seed: int,
    on_cells: Callable[[int], None] | None = None,
) -> Cells:
    """What becomes of contacts when one of them starts in each direction of a grid.

    The contact starts where the ray from the object's centre at an azimuth about the object's axis and a polar angle
    from its top first meets the surface; all others start where they do in trial 0 of a run of this seed. Outcomes are
    those of a run. ``on_cells`` hears how many cells are done. Raises DiagnosticError for axes, contacts or programs
    that cannot be mapped.
    """
    if not isinstance(program.world, Floating):
        hint = "map a world with a hand, or the floating world"
        raise refused("not-mapped", f"starts of {program.world.contacts} cannot be mapped", hint)
    x, y = (_direction(axis) for axis in wanted)
    names = program.robot.contacts
    grasp = program.phases[-1].grasp
    acting = [names[index] for index in sorted({index for phase in program.phases for index in phase.grasp.contacts})]
    moved = names[grasp.contacts[0]] if contact is None else contact
    if moved not in acting:
        hint = known_names_hint(moved, acting, "contacts of the grasp")
        raise refused("unknown-contact", f"the grasp has no contact {moved!r}", hint)
    surface = program.body.shape.surface()
    points = starts(surface, x, y, names.index(moved), len(names), seed)
    outcomes, ends, ticks = [""] * len(points), np.zeros(len(points)), np.full(len(points), math.nan)
    sliding, weight = compiled(surface, program.target.backend), program.spec.scene.gravity * program.body.mass
    world = FloatingWorld(names, sliding, weight, program.body.major_axis)
    stages, ended = stages_of(program), list[int]()
    for first in range(0, len(points), TOGETHER):
        chunk, truths = points[first : first + TOGETHER], list[Truth]()
        course = Course(program, stages, world.info, len(chunk), trajectories=False)
        beside = SideBySide(course, world, over)
        world.place(chunk)
        beside.begin(len(chunk))
        for place, (ending, witness) in beside.run():
            assert witness is not None
            truths.append(witness.truth())
            ended.append(first + place)
            outcomes[first + place] = ending.outcome.value
            if ending.outcome is Outcome.CONVERGED:
                ticks[first + place] = course.log.ticks_to_converge(place)
        ends[ended[first:]] = _orientations(truths, grasp)
        world.close()
        if on_cells is not None:
            on_cells(len(ended))
    others = {name: _angles(points[0, names.index(name)]) for name in acting if name != moved}
    return Cells(
        x=x,
        y=y,
        outcomes=tuple(outcomes),
        orientation=ends,
        ticks=ticks,
        fixed={"contact": moved, **{name: _said(angles) for name, angles in others.items()}},
        marks={name: (_within(x, angles), _within(y, angles)) for name, angles in others.items()},
        details=("",) * len(outcomes),
    )


def _orientations(truths: Sequence[Truth], grasp: ContactSet) -> Array:
    """Of the contacts of a grasp against the object's axis, (n,) [rad]."""
    points, axes = (np.array([getattr(truth, name) for truth in truths]) for name in ("points", "object_axis"))
    if grasp.has_gravity:
        points = np.concatenate([points, np.array([truth.object_position for truth in truths])[:, None]], axis=-2)
    return orientation(grasp.matrix @ points, axes)


def _direction(wanted: WantedAxis) -> Axis:
    if wanted.parameter not in WHOLE:
        hint = known_names_hint(wanted.parameter, WHOLE, "coordinates of a floating contact")
        raise refused("unknown-start-parameter", f"a floating contact has no {wanted.parameter!r}", hint)
    low, high = wanted.bounds or WHOLE[wanted.parameter]
    least, most = ALLOWED[wanted.parameter]
    if low < least - AS_TYPED or high > most + AS_TYPED:
        message = f"{wanted.parameter}: expected numbers from {least:g} to {most:g} (rad), found {low:g} to {high:g}"
        raise refused("out-of-range", message, "angles are in radians")
    return Axis(wanted.parameter, "rad", low, high, wanted.cells)


def _angles(point: Array) -> dict[str, float]:
    """The direction of a point from the object's centre [rad]."""
    return {
        "azimuth": math.atan2(point[1], point[0]),
        "polar": math.atan2(math.hypot(point[0], point[1]), point[2]),
    }


def _within(axis: Axis, angles: dict[str, float]) -> float:
    """A direction's coordinate on an axis, by whole turns from its low end on."""
    angle = angles[axis.parameter]
    return axis.low + (angle - axis.low) % (2 * math.pi) if axis.parameter == "azimuth" else angle


def _said(angles: dict[str, float]) -> str:
    return f"azimuth {angles['azimuth']:.3f} rad, polar {angles['polar']:.3f} rad"


def starts(surface: Surface, x: Axis, y: Axis, moved: int, count: int, seed: int) -> Array:
    """Contact points (n, k, 3) [m] of the cells, the columns of the first row first: one contact moved, k in all."""
    columns, rows = np.meshgrid(x.middles, y.middles)
    angles = {x.parameter: columns.ravel(), y.parameter: rows.ravel()}
    azimuth, polar = angles["azimuth"], angles["polar"]
    directions = np.column_stack(
        [np.sin(polar) * np.cos(azimuth), np.sin(polar) * np.sin(azimuth), np.cos(polar)],
    )
    drawn = surface.sample(count, np.random.default_rng(int(generator(seed, 0).integers(2**31))))
    points = np.repeat(drawn[None], len(directions), axis=0)
    points[:, moved] = towards(surface, directions)
    return points


def towards(surface: Surface, directions: Array) -> Array:
    """The first points (n, 3) [m] of a surface on the rays from its centre along unit vectors (n, 3)."""
    parts = np.split(directions, range(TOGETHER, len(directions), TOGETHER))
    return np.concatenate([_towards(surface, part) for part in parts])


def _towards(surface: Surface, directions: Array) -> Array:
    reach = np.linspace(0.0, float(np.linalg.norm(surface.extent)), ALONG_RAY)
    outside = surface.level(reach[:, None, None] * directions) > 0.0
    first = np.argmax(outside, axis=0)
    low, high = reach[first - 1], reach[first]
    for _ in range(HALVINGS):
        half = 0.5 * (low + high)
        beyond = surface.level(half[:, None] * directions) > 0.0
        low, high = np.where(beyond, low, half), np.where(beyond, half, high)
    return surface.retract(low[:, None] * directions)
