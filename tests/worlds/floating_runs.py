"""Floating contacts on known surfaces: pipelines of formulas over the points hand, starts, and runs step by step."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from compiler.specs import floating

from graspdsl.arrays import Array, Flags, Rows
from graspdsl.compiler.pipeline import Pipeline
from graspdsl.compiler.program import Program, program_of
from graspdsl.objects.cylinder import RoundedCylinder
from graspdsl.objects.ellipsoid import SmoothEllipsoid
from graspdsl.objects.shapes import catalogue
from graspdsl.objects.sphere import SmoothSphere
from graspdsl.objects.surfaces.surface import Surface
from graspdsl.trials.course import Course
from graspdsl.trials.measures import GraspMeasure
from graspdsl.trials.outcomes import Outcome
from graspdsl.trials.side_by_side import SideBySide, over
from graspdsl.trials.stages import stages_of
from graspdsl.worlds.floating import RATE, FloatingWorld, sensed, slid

RADIUS = 0.05  # m: the curvature radius that the gradients assume by default
HAND = 8  # contacts of the points hand
STARTS = 300
SEED = 0
HOLD = 20  # steps
STEPS = 1000
LOW = {"force_residual": 0.1, "moment_residual": 0.1 * RADIUS}  # ε_fr and ε_mr / r² below 1e-2

SPHERE = SmoothSphere(diameter=2 * RADIUS)
ELLIPSOID_A = SmoothEllipsoid((RADIUS, 1.2 * RADIUS, 1.5 * RADIUS))
ELLIPSOID_B = SmoothEllipsoid((RADIUS, 1.5 * RADIUS, 2.2 * RADIUS))
CYLINDER = RoundedCylinder(2 * RADIUS, 4 * RADIUS, 0.1 * RADIUS)
BOTTLE = catalogue()["bottle"].shape.surface()


def contacts(count: int) -> str:
    """{γ1, …}: the first contacts, each on its own."""
    return f"{{{', '.join(f'γ{i + 1}' for i in range(count))}}}"


def program(formula: str, resources: str, control: str = "", until: str = "contact: all", steps: int = 0) -> Program:
    """A formula in the floating world, Γ being the resources, without an end to its patience but for so many steps."""
    names = {f"γ{i + 1}": f"point-{i + 1}" for i in range(HAND)}
    parts = {"control": control, "until": until, "monitors": "progress: off"}
    text = floating(formula, resources={**names, "Γ": f'"{resources}"'}, **parts)
    return program_of(text, "test.yaml", (f"program.0.limit={steps / RATE!r}",) if steps else ())


def pipelines(formula: str, resources: str, control: str = "") -> tuple[Pipeline, ...]:
    """The stages of a formula in the floating world, Γ being the resources."""
    (stages,) = program(formula, resources, control).pipelines()
    return stages


def starts(surface: Surface, count: int = STARTS) -> Array:
    """Contacts spread evenly over the surface, (count, HAND, 3)."""
    return surface.sample(count * HAND, np.random.default_rng(SEED)).reshape(count, HAND, 3)


@dataclass(frozen=True)
class Run:
    """Where contacts got to, (N, HAND, 3) [m], and ε_fr on the way, (steps, N)."""

    points: Array
    force_errors: Array


def run(pipeline: Pipeline, surface: Surface, points: Array, steps: int) -> Run:
    """Steps of a pipeline, without any end."""
    errors = []
    for _ in range(steps):
        values = pipeline.values(sensed(surface, points, 0.0, 0.0))
        errors.append(np.sum(values[pipeline.force_residual] ** 2, axis=-1))
        points = slid(surface, points, values[pipeline.command])
    return Run(points, np.array(errors))


@dataclass(frozen=True)
class Ends:
    """What became of N starts: points (N, HAND, 3) [m], whether they converged (N,), and at which step (N,) the end
    conditions began to hold for good, all steps where they did not."""

    points: Array
    converged: Flags
    ticks: Array


def ends(
    formula: str,
    count: int,
    surface: Surface,
    points: Array,
    *,
    steps: int = STEPS,
    hold: int = HOLD,
    **bounds: float,
) -> Ends:
    """Trials of so many contacts from points (N, HAND, 3) [m], side by side, until they have held for so many steps."""
    found = Ends(points.copy(), np.zeros(len(points), dtype=bool), np.full(len(points), float(steps)))
    until = ", ".join(f"{name}: {bound!r}" for name, bound in ({**LOW, **bounds}).items() if np.isfinite(bound))
    made = program(formula, contacts(count), until=f"{until}, hold: {(hold - 1) / RATE!r}", steps=steps)
    world = FloatingWorld(made.robot.contacts, surface, 0.0)
    world.place(points)
    course = Course(made, stages_of(made), world.info, len(points), trajectories=False)
    beside = SideBySide(course, world, over)
    beside.begin(len(points))
    for place, (ending, witness) in beside.run():
        assert witness is not None
        found.points[place] = witness.truth().points
        if ending.outcome is Outcome.CONVERGED:
            found.converged[place], found.ticks[place] = True, course.log.ticks_to_converge(place)
    return found


def outcome(formula: str, count: int, surface: Surface, *, of: int = STARTS) -> Ends:
    """What becomes of starts of so many contacts."""
    return ends(formula, count, surface, starts(surface, of))


def kept(formula: str, count: int, surface: Surface) -> Flags:
    """Whether both residuals are low over the last of all steps, (STARTS,), of controllers that never end."""
    never = f"force_residual: {LOW['force_residual']}, moment_residual: 1e-300, hold: {(HOLD - 1) / RATE!r}"
    made, points = program(formula, contacts(count), until=never, steps=STEPS), starts(surface)
    world = FloatingWorld(made.robot.contacts, surface, 0.0)
    world.place(points)
    course = Course(made, stages_of(made), world.info, len(points), trajectories=False)
    write, high = course.log.write, np.full(len(points), -1)  # at which tick a residual was not low, the last time

    def watched(tick: Rows, trials: Rows, *told: Any) -> GraspMeasure:
        now = write(tick, trials, *told)
        low = (now.force_residual < LOW["force_residual"]) & (now.moment_residual < LOW["moment_residual"])
        high[trials[~low]] = tick[~low]
        return now

    course.log.write = watched
    beside = SideBySide(course, world, over)
    beside.begin(len(points))
    low = np.zeros(len(points), dtype=bool)
    for place, (ending, _) in beside.run():
        assert ending.outcome in (Outcome.TIMEOUT, Outcome.UNDONE)  # time was up
        low[place] = course.log.last[place] - high[place] >= HOLD
    return low


def degrees_between(one: Array, other: Array) -> Array:
    """The angles [deg] between vectors (..., 3)."""
    sine, cosine = np.linalg.norm(np.cross(one, other), axis=-1), np.sum(one * other, axis=-1)
    return np.degrees(np.arctan2(sine, cosine))
