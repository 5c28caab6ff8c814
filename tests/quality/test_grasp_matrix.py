"""The grasp matrix against closed forms and against one put together another way."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from graspdsl.basis.algebra import skew
from graspdsl.quality.contact_models import ContactModel, FrictionlessPoint, HardPoint, SoftFinger
from graspdsl.quality.grasp_matrix import grasp_matrix, least_singular_value
from graspdsl.quality.wrench_space import wrench_space
from quality.grasps import Contacts, antipodal, random_contacts, ring

HARD, SOFT = HardPoint(0.5), SoftFinger(0.5, 0.002)
RADIUS, LENGTH = 0.05, 0.03


@pytest.mark.parametrize("count", [2, 3, 5])
def test_it_makes_the_wrench_of_forces(count: int) -> None:
    points, normals = random_contacts(count, count)
    reference = np.array([0.01, -0.02, 0.005])
    space = wrench_space(points, normals, SOFT, reference=reference, length=LENGTH)
    parts = np.random.default_rng(1).normal(size=(count, 4))  # of forces, and of moments over the length
    wrench = np.zeros(6)
    for point, frame, (*force, moment) in zip(points, space.basis[:, :3, :3], parts, strict=True):
        pushed = frame.T @ force
        wrench += np.concatenate([pushed, np.cross(point - reference, pushed) / LENGTH + moment * frame[0]])
    np.testing.assert_allclose(grasp_matrix(space) @ parts.ravel(), wrench, atol=1e-12)


@pytest.mark.parametrize(
    ("contacts", "model", "expected"),
    [
        # Forces give √k; moments, of levers r around a circle, √(k/2) r / λ across it and √k r / λ about its axis.
        (ring(3, RADIUS), HARD, math.sqrt(1.5) * min(math.sqrt(2.0), RADIUS / LENGTH)),
        (ring(6, 0.01), HARD, math.sqrt(3.0) * 0.01 / LENGTH),
        # About the line between two soft fingers both turn the object: √2.
        (antipodal(RADIUS), SOFT, math.sqrt(2.0)),
        (antipodal(0.01), SOFT, math.sqrt(2.0) * 0.01 / LENGTH),
        (antipodal(RADIUS), HARD, 0.0),
        (ring(3, RADIUS), FrictionlessPoint(), 0.0),
    ],
)
def test_closed_forms(contacts: Contacts, model: ContactModel, expected: float) -> None:
    found = least_singular_value(wrench_space(*contacts, model, reference=np.zeros(3), length=LENGTH))
    assert found.value == pytest.approx(expected, abs=1e-12)
    assert bool(found.reason) is (expected == 0.0)


@pytest.mark.parametrize("model", [HARD, SOFT])
@pytest.mark.parametrize("seed", range(4))
def test_it_is_that_of_forces_along_the_axes_of_the_world(model: ContactModel, seed: int) -> None:
    """G Gᵀ needs no contact frames: Σ [1, r̂ᵀ; r̂, r̂ r̂ᵀ] of hard contacts, with n nᵀ for the moments of soft ones."""
    points, normals = random_contacts(seed, 3)
    turn = Rotation.random(random_state=seed).as_matrix()
    space = wrench_space(points @ turn.T, normals @ turn.T, model, length=LENGTH)
    square = np.zeros((6, 6))
    for lever, normal in zip((points - points.mean(axis=0)) / LENGTH, normals, strict=True):
        each = np.vstack([np.eye(3), skew(lever)])
        square += each @ each.T
        if model is SOFT:
            square[3:, 3:] += np.outer(normal, normal)
    assert least_singular_value(space).value == pytest.approx(math.sqrt(np.linalg.eigvalsh(square)[0]), rel=1e-9)
