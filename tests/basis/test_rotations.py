"""Exponential coordinates against scipy's rotations, from no turn at all to half a turn."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from graspdsl.angles import roll_pitch_yaw
from graspdsl.arrays import Array
from graspdsl.basis.rotations import exponential, logarithm, turn_between, turned
from graspdsl.contracts.drawing import generator, unit_vectors

CLOSE = 1e-12
SMALL = np.concatenate([[0.0], np.logspace(-16, -1, 61)])
ANGLES = np.concatenate([SMALL, np.linspace(0.1, np.pi - 0.1, 40), np.pi - SMALL[1:]])
AXES = np.concatenate([unit_vectors(generator(), 40), np.eye(3), -np.eye(3), [[0.6, 0.8, 0.0], [0.0, -0.6, 0.8]]])
VECTORS = ANGLES[:, None, None] * AXES


def matrices(vectors: Array) -> Array:
    """What scipy makes of rotation vectors (..., 3)."""
    return Rotation.from_rotvec(vectors.reshape(-1, 3)).as_matrix().reshape(*vectors.shape, 3)


def apart(one: Array, other: Array) -> float:
    """The largest difference between rotation vectors, half a turn to either side being the same turn."""
    lengths = np.linalg.norm(one, axis=-1, keepdims=True)
    around = one - 2 * np.pi * one / np.where(lengths > 0.0, lengths, 1.0)
    nearest = np.minimum(np.linalg.norm(one - other, axis=-1), np.linalg.norm(around - other, axis=-1))
    return float(nearest.max())


def test_exponential_is_scipys() -> None:
    np.testing.assert_allclose(exponential(VECTORS), matrices(VECTORS), atol=CLOSE)
    long = 10.0 * generator().normal(size=(50, 3))
    np.testing.assert_allclose(exponential(long), matrices(long), atol=CLOSE)


def test_exponential_is_a_rotation() -> None:
    rotations = exponential(VECTORS)
    np.testing.assert_allclose(
        rotations @ np.swapaxes(rotations, -1, -2), np.broadcast_to(np.eye(3), rotations.shape), atol=CLOSE
    )
    np.testing.assert_allclose(np.linalg.det(rotations), 1.0, atol=CLOSE)


def test_logarithm_takes_the_exponential_back() -> None:
    found = logarithm(exponential(VECTORS))
    assert apart(found, VECTORS) < CLOSE
    short = np.pi - 1e-11 >= ANGLES
    np.testing.assert_allclose(found[short], VECTORS[short], atol=CLOSE)


def test_logarithm_of_scipys_matrices() -> None:
    rotations = Rotation.random(500, random_state=3)
    np.testing.assert_allclose(logarithm(rotations.as_matrix()), rotations.as_rotvec(), atol=CLOSE)


def test_exponential_takes_the_logarithm_back() -> None:
    half_turns = 2 * AXES[:, :, None] * AXES[:, None, :] - np.eye(3)
    rotations = np.concatenate([Rotation.random(500, random_state=4).as_matrix(), half_turns, np.eye(3)[None]])
    np.testing.assert_allclose(exponential(logarithm(rotations)), rotations, atol=CLOSE)
    assert np.all(np.linalg.norm(logarithm(rotations), axis=-1) <= np.pi * (1 + 1e-15))


def test_small_vectors_keep_their_digits() -> None:
    """Relative to their length, down to the smallest turn that a matrix of numbers near one can hold."""
    for angle in np.logspace(-9, -2, 30):
        found = logarithm(exponential(angle * AXES))
        assert np.abs(found - angle * AXES).max() < max(1e-15, 1e-12 * angle)


def test_no_turn() -> None:
    np.testing.assert_array_equal(exponential(np.zeros(3)), np.eye(3))
    np.testing.assert_array_equal(logarithm(np.eye(3)), np.zeros(3))


def test_turns_follow_one_another_in_fixed_axes() -> None:
    first, then = (Rotation.random(200, random_state=seed) for seed in (5, 6))
    found = turned(then.as_rotvec(), first.as_rotvec())
    np.testing.assert_allclose(matrices(found), (then * first).as_matrix(), atol=CLOSE)
    np.testing.assert_allclose(matrices(turn_between(found, first.as_rotvec())), then.as_matrix(), atol=CLOSE)
    between = turn_between(then.as_rotvec(), first.as_rotvec())
    np.testing.assert_allclose(between, (then * first.inv()).as_rotvec(), atol=1e-10)


@pytest.mark.parametrize("function", [turned, turn_between])
def test_batches_and_broadcasts(function: object) -> None:
    assert callable(function)
    many, one = 0.5 * generator().normal(size=(2, 3, 4, 3)), generator().normal(size=3)
    whole = function(many, one)
    assert whole.shape == many.shape
    for place in np.ndindex(2, 3, 4):
        np.testing.assert_allclose(whole[place], function(many[place], one), atol=1e-15)


def test_roll_pitch_and_yaw_make_the_rotation_also_where_the_pitch_is_a_right_angle() -> None:
    pitches = [side * (np.pi / 2 - away) for side in (-1.0, 1.0) for away in (0.0, *np.logspace(-16, 0, 33))]
    angles = [(roll, pitch, yaw) for roll in (-3.0, 0.0, 0.7) for pitch in pitches for yaw in (-1.2, 0.0, np.pi)]
    random = Rotation.random(100, random_state=4)
    for rotation in (*Rotation.from_euler("xyz", angles).as_matrix(), *random.as_matrix()):
        found = Rotation.from_euler("xyz", roll_pitch_yaw(rotation)).as_matrix()
        np.testing.assert_allclose(found, rotation, atol=CLOSE)
