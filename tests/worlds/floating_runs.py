"""Floating contacts on known surfaces: pipelines of formulas over the points hand, starts, and runs step by step."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from compiler.specs import floating

from graspdsl.arrays import Array
from graspdsl.compiler.pipeline import Pipeline
from graspdsl.compiler.program import program_of
from graspdsl.objects.cylinder import RoundedCylinder
from graspdsl.objects.ellipsoid import SmoothEllipsoid
from graspdsl.objects.shapes import catalogue
from graspdsl.objects.sphere import SmoothSphere
from graspdsl.objects.surfaces.surface import Surface
from graspdsl.trials.batch import BatchResult, run_batch
from graspdsl.worlds.floating import sensed, slid

RADIUS = 0.05  # m: the curvature radius that the gradients assume by default
HAND = 8  # contacts of the points hand
STARTS = 300
SEED = 0
LOW = {"force_bound": 0.1, "moment_bound": 0.1 * RADIUS}  # ε_fr and ε_mr / r² below 1e-2

SPHERE = SmoothSphere(diameter=2 * RADIUS)
ELLIPSOID_A = SmoothEllipsoid((RADIUS, 1.2 * RADIUS, 1.5 * RADIUS))
ELLIPSOID_B = SmoothEllipsoid((RADIUS, 1.5 * RADIUS, 2.2 * RADIUS))
CYLINDER = RoundedCylinder(2 * RADIUS, 4 * RADIUS, 0.1 * RADIUS)
BOTTLE = catalogue()["bottle"].shape.surface()


def contacts(count: int) -> str:
    """{γ1, …}: the first contacts, each on its own."""
    return f"{{{', '.join(f'γ{i + 1}' for i in range(count))}}}"


def pipelines(formula: str, resources: str, control: str = "") -> tuple[Pipeline, ...]:
    """The stages of a formula in the floating world, Γ being the resources."""
    names = {f"γ{i + 1}": f"point-{i + 1}" for i in range(HAND)}
    text = floating(formula, resources={**names, "Γ": f'"{resources}"'}, control=control)
    (stages,) = program_of(text, "test.yaml").pipelines()
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


def outcome(
    formula: str, count: int, surface: Surface, *, of: int = STARTS, steps: int = 1000, stop: bool = True
) -> BatchResult:
    """What becomes of starts of so many contacts."""
    return run_batch(pipelines(formula, contacts(count)), surface, starts(surface, of), steps=steps, stop=stop, **LOW)


def degrees_between(one: Array, other: Array) -> Array:
    """The angles [deg] between vectors (..., 3)."""
    sine, cosine = np.linalg.norm(np.cross(one, other), axis=-1), np.sum(one * other, axis=-1)
    return np.degrees(np.arctan2(sine, cosine))
