"""Maps over where one floating contact starts: every cell at once, in a batch."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from graspdsl.arrays import Array
from graspdsl.compiler.pipeline import Pipeline
from graspdsl.compiler.program import Program
from graspdsl.diagnostics import known_names_hint
from graspdsl.objects.surfaces.surface import Surface
from graspdsl.spec.monitors import OFF
from graspdsl.spec.program import Until
from graspdsl.trials.batch import BatchStage, run_stages
from graspdsl.trials.cells import Axis, Cells
from graspdsl.trials.grids import WantedAxis, refused
from graspdsl.trials.measures import orientation
from graspdsl.trials.outcomes import Outcome
from graspdsl.trials.stage import until_of
from graspdsl.trials.stalling import StallWatch
from graspdsl.trials.starts import generator
from graspdsl.worlds.floating import RATE
from graspdsl.worlds.protocol import GRAVITY

TOGETHER = 2000  # cells in a batch, which bounds the memory
WHOLE = {"azimuth": (-math.pi, math.pi), "polar": (0.0, math.pi)}  # rad
ALLOWED = {"azimuth": (-2 * math.pi, 2 * math.pi), "polar": (0.0, math.pi)}  # rad
AS_TYPED = 1e-3  # rad, by which a rounded π may miss
ALONG_RAY = 256  # points looked at
HALVINGS = 60
ROUNDING = 1e-9  # ticks


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
    x, y = (_axis(axis) for axis in wanted)
    names = program.robot.contacts
    grasp = program.phases[-1].grasp
    acting = [names[index] for index in sorted({index for phase in program.phases for index in phase.grasp.contacts})]
    moved = names[grasp.contacts[0]] if contact is None else contact
    if moved not in acting:
        hint = known_names_hint(moved, acting, "contacts of the grasp")
        raise refused("unknown-contact", f"the grasp has no contact {moved!r}", hint)
    if any(phase.hysteresis for phase in program.spec.program):
        message = "a map of floating contacts cannot go back to an earlier stage, as hysteresis asks"
        raise refused("not-mapped", message, "map without: --set program.0.hysteresis=null")
    surface = program.body.shape.surface()
    points = starts(surface, x, y, names.index(moved), len(names), seed)
    runs = []
    for first in range(0, len(points), TOGETHER):
        runs.append(run_program(program, surface, points[first : first + TOGETHER]))
        if on_cells is not None:
            on_cells(min(first + TOGETHER, len(points)))
    ends, axis = np.concatenate([run.points for run in runs]), np.array(program.body.major_axis)
    outcomes = [outcome for run in runs for outcome in run.outcomes]
    others = {name: _angles(points[0, names.index(name)]) for name in acting if name != moved}
    return Cells(
        x=x,
        y=y,
        outcomes=tuple(outcome.value for outcome in outcomes),
        orientation=np.array([orientation(grasp.matrix @ cell, axis) for cell in ends]),
        ticks=np.concatenate([run.ticks for run in runs]),
        fixed={"contact": moved, **{name: _said(angles) for name, angles in others.items()}},
        marks={name: (_within(x, angles), _within(y, angles)) for name, angles in others.items()},
        details=("",) * len(outcomes),
    )


def _axis(wanted: WantedAxis) -> Axis:
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
    reach = np.linspace(0.0, float(np.linalg.norm(surface.extent)), ALONG_RAY)
    outside = surface.level(reach[:, None, None] * directions) > 0.0
    first = np.argmax(outside, axis=0)
    low, high = reach[first - 1], reach[first]
    for _ in range(HALVINGS):
        half = 0.5 * (low + high)
        beyond = surface.level(half[:, None] * directions) > 0.0
        low, high = np.where(beyond, low, half), np.where(beyond, half, high)
    return surface.retract(low[:, None] * directions)


@dataclass(frozen=True, slots=True)
class ProgramEnds:
    """Where and how n starts ended: points (n, k, 3) [m], outcomes and ticks (n,) to converge, NaN for those that did
    not. As in the record of a trial, ticks count from where the second phase begins, if there is one."""

    points: Array
    outcomes: tuple[Outcome, ...]
    ticks: Array


def run_program(program: Program, surface: Surface, points: Array) -> ProgramEnds:
    """Run a program's phases, one after the other, from points (n, k, 3) [m]."""
    count, points = len(points), points.copy()
    weight = GRAVITY * program.body.mass
    outcomes = [Outcome.CONVERGED] * count
    passed, ticks, active = np.zeros(count), np.zeros(count), np.arange(count)
    phases = zip(program.phases, program.spec.program, program.pipelines(), strict=True)
    for index, (phase, settings, pipelines) in enumerate(phases):
        until = settings.until
        conditions = [*[until_of(stage, until) for stage in phase.stages[:-1]], until]
        stages = [_stage(*pair) for pair in zip(pipelines, conditions, strict=True)]
        waits_for_residual = not (until.force_residual is None and until.moment_residual is None)
        watch = _stall_watch(program, len(active)) if waits_for_residual else None
        hold = math.ceil(until.hold * RATE - ROUNDING) + 1
        steps = math.ceil(settings.limit * RATE - ROUNDING)
        done = run_stages(stages, surface, points[active], hold=hold, steps=steps, weight=weight, stalling=watch)
        points[active] = done.points
        ticks[active] = passed[active] + done.ticks
        if index > 0:  # a trial counts from the second phase on: in the first its contacts have touched
            passed[active] += done.ticks + hold - 1
        for cell, stalled in zip(active[~done.converged], done.stalled[~done.converged], strict=True):
            outcomes[cell], ticks[cell] = Outcome.LOCAL_MINIMUM if stalled else Outcome.TIMEOUT, math.nan
        active = active[done.converged]
    return ProgramEnds(points, tuple(outcomes), ticks)


def _stall_watch(program: Program, count: int) -> StallWatch | None:
    progress = program.monitors.progress
    if progress == OFF:
        return None
    window = round(progress.window * RATE)
    return StallWatch(count, window, program.spec.control.curvature_radius, progress.least)


def _stage(pipeline: Pipeline, until: Until) -> BatchStage:
    force = math.inf if until.force_residual is None else until.force_residual
    moment = math.inf if until.moment_residual is None else until.moment_residual
    return BatchStage(pipeline, force, moment)
