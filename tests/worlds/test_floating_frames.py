"""What a run does not depend on: the choice of the world's axes, for tangent frames; the chapter's angles do."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from graspdsl.arrays import Array
from graspdsl.objects.surfaces.surface import Surface

from .floating_runs import ELLIPSOID_B, HAND, degrees_between, pipelines, run, starts

pytestmark = pytest.mark.slow

TURNS = Rotation.random(5, random_state=1).as_matrix()
STEPS = 50


@dataclass(frozen=True)
class Turned(Surface):
    """A surface in a world whose axes are turned: a body point p is at R p."""

    body: Surface
    rotation: Array

    @property
    def extent(self) -> tuple[float, float, float]:
        """Of the body, to which lengths compare."""
        return self.body.extent

    def level(self, points: Array) -> Array:
        """The body's."""
        return self.body.level(points @ self.rotation)

    def normals(self, points: Array) -> Array:
        """The body's, turned."""
        return self.body.normals(points @ self.rotation) @ self.rotation.T

    def nearest(self, points: Array) -> Array:
        """The body's, turned."""
        return self.body.nearest(points @ self.rotation) @ self.rotation.T

    def sample(self, count: int, random: np.random.Generator) -> Array:
        """The body's, turned."""
        return self.body.sample(count, random) @ self.rotation.T

    def rings(self, count: int) -> Array:
        """The body's, turned."""
        return self.body.rings(count) @ self.rotation.T


def astray(formula: str, resources: str, control: str) -> Array:
    """How far [deg, as seen from the centre] contacts end from where they do in a world that is not turned."""
    (pipeline,) = pipelines(formula, resources, control)
    here = starts(ELLIPSOID_B, 100)
    used = slice(None, resources.count("γ"))
    straight = run(pipeline, ELLIPSOID_B, here, STEPS).points
    assert np.median(degrees_between(straight, here)[:, used]) > 10.0
    found = []
    for turn in TURNS:
        there = run(pipeline, Turned(ELLIPSOID_B, turn), here @ turn.T, STEPS).points
        found.append(degrees_between(there @ turn, straight)[:, used])
    return np.array(found)


EACH_FORMULA = pytest.mark.parametrize("formula", ["π_gx|Γ Γ", "π_g|Γ Γ"])
EACH_GRASP = pytest.mark.parametrize("resources", ["{γ1, γ2, γ3}", "{γ1, <γ2, γ3>}"])


@EACH_FORMULA
@EACH_GRASP
@pytest.mark.parametrize("nullspace", ["gradient", "task"])
@pytest.mark.parametrize("virtual", ["members", "common"])
def test_runs_turn_with_the_world_in_tangent_frames(formula: str, resources: str, nullspace: str, virtual: str) -> None:
    # Half the default step: on a full one a single run of the task form cycles, and cycles magnify rounding errors.
    settings = f"nullspace: {nullspace}, virtual: {virtual}, step: 0.008"
    assert astray(formula, resources, settings).max() < 1e-4


@EACH_FORMULA
@EACH_GRASP
def test_runs_depend_on_the_world_in_the_chapters_coordinates(formula: str, resources: str) -> None:
    apart = astray(formula, resources, "surface: spherical")
    assert np.median(apart) > 1.0


def test_the_turned_surface_is_the_body_turned() -> None:
    points, turned = starts(ELLIPSOID_B, 10), Turned(ELLIPSOID_B, TURNS[0])
    assert points.shape == (10, HAND, 3)
    np.testing.assert_allclose(turned.level(points @ TURNS[0].T), 0.0, atol=1e-15)
