"""Contact models and primitive wrenches: limits of friction, moments, reference and scale."""

from __future__ import annotations

import math

import numpy as np
import pytest

from graspdsl.arrays import Array
from graspdsl.quality.contact_models import (
    ContactModel,
    FrictionlessPoint,
    HardPoint,
    SoftFinger,
)
from graspdsl.quality.wrench_space import contact_frames, wrench_space
from quality.grasps import antipodal, random_contacts, ring


@pytest.mark.parametrize(
    ("model", "edges"),
    [(FrictionlessPoint(), 1), (HardPoint(0.5), 16), (HardPoint(0.5, 8), 8), (SoftFinger(0.5, 0.002), 32)],
)
def test_edges_push_with_unit_normal_force_at_the_limits(model: ContactModel, edges: int) -> None:
    generators = model.generators()
    assert generators.shape == (edges, 4)
    np.testing.assert_array_equal(generators[:, 0], 1.0)
    sideways = np.linalg.norm(generators[:, 1:3], axis=1)
    np.testing.assert_allclose(sideways, getattr(model, "friction", 0.0), atol=1e-15)
    np.testing.assert_allclose(np.abs(generators[:, 3]), getattr(model, "torsion", 0.0), atol=0)


def test_models_without_friction_and_without_torsion_are_the_simpler_ones() -> None:
    np.testing.assert_array_equal(HardPoint(0.0).generators(), FrictionlessPoint().generators())
    np.testing.assert_array_equal(SoftFinger(0.3, 0.0).generators(), HardPoint(0.3).generators())


@pytest.mark.parametrize(("friction", "edges"), [(-0.1, 16), (math.nan, 16), (math.inf, 16), (0.5, 2), (0.5, 7)])
def test_coefficients_and_edges_that_make_no_sense(friction: float, edges: int) -> None:
    with pytest.raises(ValueError, match="friction"):
        HardPoint(friction, edges)


def test_a_negative_torsional_coefficient() -> None:
    with pytest.raises(ValueError, match="torsional"):
        SoftFinger(0.5, -1e-3)


@pytest.mark.parametrize("model", [HardPoint(0.6), SoftFinger(0.6, 0.004)])
def test_wrenches_are_forces_within_the_cone_and_their_moments(model: ContactModel) -> None:
    points, normals = random_contacts(1, 4)
    reference, length = np.array([0.01, 0.02, -0.03]), 0.07
    space = wrench_space(points, normals, model, reference=reference, length=length)
    each = space.wrenches.reshape(4, -1, 6)
    for point, normal, wrenches in zip(points, normals, each, strict=True):
        forces, moments = wrenches[:, :3], length * wrenches[:, 3:]
        along = forces @ normal
        np.testing.assert_allclose(along, 1.0, atol=1e-12)
        np.testing.assert_allclose(np.linalg.norm(forces - np.outer(along, normal), axis=1), 0.6, atol=1e-12)
        free = moments - np.cross(point - reference, forces)  # what a point force does not explain
        expected = getattr(model, "torsion", 0.0)
        np.testing.assert_allclose(np.abs(free @ normal), expected, atol=1e-12)
        np.testing.assert_allclose(np.linalg.norm(free, axis=1), expected, atol=1e-12)


def test_frames_are_right_handed_and_turn_with_the_grasp() -> None:
    points, normals = random_contacts(5, 4)
    frames = contact_frames(points, normals)
    np.testing.assert_allclose(frames @ np.swapaxes(frames, 1, 2), np.tile(np.eye(3), (4, 1, 1)), atol=1e-12)
    np.testing.assert_allclose(np.linalg.det(frames), 1.0)
    np.testing.assert_allclose(frames[:, 0], normals)


def test_reference_and_length_by_default() -> None:
    points, normals = ring()
    space = wrench_space(points + 1.0, normals, HardPoint(0.5))
    np.testing.assert_allclose(space.reference, 1.0)
    assert space.length == pytest.approx(0.05)
    assert space.model.name == "hard point contact, μ = 0.5"
    assert wrench_space(points[:1], normals[:1], HardPoint(0.5)).length == 1.0


def test_rank() -> None:
    points, normals = antipodal()
    assert wrench_space(points, normals, HardPoint(0.5)).rank == 5
    assert wrench_space(points, normals, SoftFinger(0.5, 1e-4)).rank == 6
    assert wrench_space(points, normals, FrictionlessPoint()).rank == 1
    assert wrench_space(points[:0], normals[:0], FrictionlessPoint()).rank == 0


@pytest.mark.parametrize(
    ("points", "normals", "length"),
    [
        (np.zeros((2, 3)), np.ones((3, 3)), None),
        (np.zeros(3), np.ones(3), None),
        (np.full((1, 3), np.nan), np.ones((1, 3)), None),
        (np.zeros((1, 3)), np.zeros((1, 3)), None),
        (np.zeros((1, 3)), np.ones((1, 3)), 0.0),
    ],
)
def test_contacts_that_make_no_sense(points: Array, normals: Array, length: float | None) -> None:
    with pytest.raises(ValueError, match=r"points and normals|finite|length"):
        wrench_space(points, normals, HardPoint(0.5), length=length)
