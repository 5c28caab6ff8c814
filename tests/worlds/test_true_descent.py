"""The controller that descends the true ε_w: its gradient is that of real slides, and it stops where ε_w is least."""

from __future__ import annotations

import numpy as np
import pytest
from compiler.specs import floating, spec

from graspdsl.arrays import Array
from graspdsl.basis.algebra import tangent_frames
from graspdsl.compiler.program import Program, examine, program_of
from graspdsl.objects.surfaces.surface import Surface
from graspdsl.worlds.floating import sensed, slid

R, STEP, CONFIGURATIONS = 0.05, 1e-6, 40  # m; a step that no cap shortens
APART = 1e-6 * R
UNTIL = "force_residual: 0.1, moment_residual: 0.005"
SHAPES = {
    "ellipsoid": "{ellipsoid: {size: [0.10, 0.15, 0.22]}}",
    "superquadric": "{superquadric: {size: [0.10, 0.12, 0.16], exponent: 3.0}}",
    "cylinder": "{cylinder: {diameter: 0.10, height: 0.20, edge: 0.02}}",
    "bottle": "bottle",
}
SETS = {
    "all": ("{γ1, γ2, γ3}", "{γ1, γ2, γ3}", (1.0, 1.0, 1.0), "centroid"),
    "one held fixed": ("{γ2, γ3}", "{γ1, γ2, γ3}", (0.0, 1.0, 1.0), "centroid"),
    "a virtual contact": ("{γ1, <γ2, γ3>}", "{γ1, <γ2, γ3>}", (1.0, 1.0, 1.0), "centroid"),
    "about the object": ("{γ1, γ2, γ3}", "{γ1, γ2, γ3}", (1.0, 1.0, 1.0), "object"),
}


def descending(shape: str, moved: str, sensed_by: str, control: str = "", effector: str = "τ_wsx") -> Program:
    """A program of φ_w, over the true surface or its model."""
    formula = f"φ_w|{effector}({moved}) σ_w({sensed_by})"
    return program_of(floating(formula, scene=f"object: {shape}", until=UNTIL, control=control), "spec")


def drawn(made: Program, count: int, seed: int) -> Array:
    """Places (count, k, 3) [m] of all contacts."""
    contacts = len(made.robot.contacts)
    points = made.body.shape.surface().sample(count * contacts, np.random.default_rng(seed))
    return points.reshape(count, contacts, 3)


def energy(surface: Surface, points: Array, weights: Array, origin: str) -> Array:
    """ε_w of contacts at points (..., k, 3)."""
    inward = -surface.normals(points)
    centre = (weights[:, None] * points).sum(axis=-2, keepdims=True) / weights.sum() if origin == "centroid" else 0.0
    force = np.einsum("i,...ij->...j", weights, inward)
    moment = np.einsum("i,...ij->...j", weights, np.cross(points - centre, inward)) / R
    return np.asarray((force**2).sum(axis=-1) + (moment**2).sum(axis=-1))


@pytest.mark.parametrize("shape", SHAPES.values(), ids=SHAPES)
@pytest.mark.parametrize(("moved", "sensing", "moves", "origin"), SETS.values(), ids=SETS)
def test_it_goes_down_the_gradient_of_real_slides(
    shape: str, moved: str, sensing: str, moves: tuple[float, ...], origin: str
) -> None:
    """−½ k ∇ε_w by central differences along slides with retraction, to 1e-6, for contacts that move."""
    made = descending(shape, moved, sensing, f"step: {STEP}, origin: {origin}")
    surface, ((pipeline,),) = made.body.shape.surface(), made.pipelines()
    points = drawn(made, CONFIGURATIONS, 417)
    found = pipeline.ticks(sensed(surface, points, 0.0, 0.0)).displacement / (-0.5 * STEP * R)
    frames, weights = tangent_frames(surface.normals(points)), made.phases[0].grasp.weights
    wanted = np.zeros_like(points)
    for contact in np.flatnonzero(moves):
        for axis in range(2):
            along = np.zeros_like(points)
            along[:, contact] = frames[:, contact, :, axis]
            ahead, behind = (
                energy(surface, slid(surface, points, sign * APART * along), weights, origin) for sign in (1.0, -1.0)
            )
            wanted += along * ((ahead - behind) / (2.0 * APART))[:, None, None]
    np.testing.assert_allclose(found, wanted, atol=1e-6 * np.abs(wanted).max())


@pytest.mark.slow
def test_where_it_rests_is_a_local_minimum_of_the_wrench() -> None:
    """With one contact held fixed it often comes to rest with a wrench left, and no small slide of the others is any
    better; the model's descent rests where the true wrench could fall on."""
    rests = {}
    for effector in ("τ_wsx", "τ_wx"):
        made = descending("{ellipsoid: {size: [0.10, 0.12, 0.15]}}", "{γ2, γ3}", "{γ1, γ2, γ3}", effector=effector)
        surface, ((pipeline,),), weights = made.body.shape.surface(), made.pipelines(), made.phases[0].grasp.weights
        points, step = drawn(made, 40, 418), np.array([np.inf])
        for _ in range(600):
            step = pipeline.ticks(sensed(surface, points, 0.0, 0.0)).displacement
            points = slid(surface, points, step)
        resting = points[(np.abs(step).max(axis=(1, 2)) < 1e-8)]
        left = energy(surface, resting, weights, "centroid")
        resting, left = resting[left > 1e-2], left[left > 1e-2]
        assert len(resting) > 4
        tries = 1e-4 * np.random.default_rng(419).normal(size=(200, 1, *points.shape[1:]))
        tries[:, :, 0] = 0.0
        around = energy(surface, slid(surface, resting, tries), weights, "centroid")
        rests[effector] = (around.min(axis=0) - left) / left
    assert rests["τ_wsx"].min() > -1e-8
    assert rests["τ_wx"].max() < -1e-4


def test_where_the_surface_is_not_known_there_is_none() -> None:
    """No hand senses how a surface curves: one complaint, with a way out."""
    text = spec("φ_p|τ_p(Γ) σ_p(Γ) (φ_w|τ_wsx(Γ) σ_w(Γ))", until="contact: all")
    [complaint] = [found for found in examine(text, "spec").diagnostics if found.code == "not-sensed"]
    assert "τ_wsx" in complaint.message
    assert "floating" in (complaint.hint or "")
