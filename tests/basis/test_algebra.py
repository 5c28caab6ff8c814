"""Small linear algebra against numpy's, and the properties that make projectors and frames what they are."""

from __future__ import annotations

import numpy as np
import pytest

from graspdsl.arrays import Array
from graspdsl.basis.algebra import (
    along,
    cross,
    damped_pseudo_inverse,
    in_columns,
    in_rows,
    length,
    null_space_projector,
    scaled_transpose,
    skew,
    spherical_frames,
    spherical_stretch,
    tangent_frames,
)
from graspdsl.basis.operations import (
    across,
    approach,
    directions,
    excess,
    longest,
    pressing,
    rank,
    rank_across,
    side_by_side,
    times,
    transposed_times,
)
from graspdsl.contracts.drawing import generator, unit_vectors

POLES = np.array([[0.0, 0.0, 1.0], [0.0, 0.0, -1.0], [0.0, -0.0, 1.0], [1e-9, 0.0, -1.0], [1.0, 0.0, -0.0]])


def _normals() -> Array:
    return np.concatenate([unit_vectors(generator(), 10_000), POLES])


def test_cross_is_numpys() -> None:
    a, b = generator().normal(size=(2, 4, 5, 3))
    np.testing.assert_allclose(cross(a, b), np.cross(a, b), atol=1e-15)
    np.testing.assert_allclose(cross(a, b[0, 0]), np.cross(a, b[0, 0]), atol=1e-15)


def test_skew_is_cross() -> None:
    a, b = generator().normal(size=(2, 4, 5, 3))
    np.testing.assert_allclose(np.einsum("...ij,...j->...i", skew(a), b), cross(a, b), atol=1e-15)
    np.testing.assert_array_equal(skew(a), -np.swapaxes(skew(a), -1, -2))


def _tangent_projectors(normals: Array) -> Array:
    projectors: Array = np.eye(3) - normals[..., :, None] * normals[..., None, :]
    return projectors


def test_along_and_tangent_projector_part_a_vector() -> None:
    normals = _normals()
    vectors = generator().normal(size=normals.shape)
    tangential = np.einsum("...ij,...j->...i", _tangent_projectors(normals), vectors)
    np.testing.assert_allclose(along(vectors, normals) + tangential, vectors, atol=1e-14)
    np.testing.assert_allclose(cross(along(vectors, normals), normals), 0.0, atol=1e-14)
    np.testing.assert_allclose(np.sum(tangential * normals, axis=-1), 0.0, atol=1e-14)


def test_tangent_frames_are_right_handed_and_orthonormal() -> None:
    normals = _normals()
    frames = np.concatenate([tangent_frames(normals), normals[..., None]], axis=-1)
    np.testing.assert_allclose(
        np.swapaxes(frames, -1, -2) @ frames, np.broadcast_to(np.eye(3), frames.shape), atol=1e-9
    )
    np.testing.assert_allclose(np.linalg.det(frames), 1.0, atol=1e-9)


def test_frames_span_the_tangent_plane() -> None:
    normals = _normals()
    for frames in (tangent_frames(normals), spherical_frames(normals)):
        np.testing.assert_allclose(frames @ np.swapaxes(frames, -1, -2), _tangent_projectors(normals), atol=1e-9)


def test_spherical_frames_point_east_and_north() -> None:
    """East is level, north climbs, and the two turn with the outward normal as a right-handed frame."""
    normals = _normals()
    frames = spherical_frames(normals)
    np.testing.assert_array_equal(frames[..., 2, 0], 0.0)
    assert np.all(frames[..., 2, 1] >= 0.0)
    np.testing.assert_allclose(cross(frames[..., 0], frames[..., 1]), -normals, atol=1e-9)
    np.testing.assert_allclose(spherical_stretch(normals)[..., 0], frames[..., 2, 1], atol=1e-15)
    np.testing.assert_array_equal(spherical_stretch(normals)[..., 1], 1.0)


def test_blocks_stand_side_by_side_or_on_top_of_each_other() -> None:
    blocks = generator().normal(size=(2, 4, 3, 5))
    for one, wide, tall in zip(blocks, in_columns(blocks), in_rows(blocks), strict=True):
        np.testing.assert_array_equal(wide, np.hstack(list(one)))
        np.testing.assert_array_equal(tall, np.vstack(list(one)))


@pytest.mark.parametrize("shape", [(3, 7), (7, 3), (5, 5), (1, 4)])
def test_damped_pseudo_inverse_nears_the_pseudo_inverse(shape: tuple[int, int]) -> None:
    jacobian = generator().normal(size=shape)
    exact = np.linalg.pinv(jacobian)
    far, near = (np.abs(damped_pseudo_inverse(damping, jacobian) - exact).max() for damping in (1e-1, 1e-3))
    assert near < 1e-4
    assert near < far / 1e3


def test_damped_pseudo_inverse_is_bounded_where_the_jacobian_is_singular() -> None:
    damping = 0.02
    jacobian = np.outer([1.0, 2.0, 3.0], [1.0, 0.0, 1e-9, 1.0])
    for singular in (jacobian, 1e-6 * jacobian, np.zeros((3, 4))):
        assert np.linalg.norm(damped_pseudo_inverse(damping, singular), 2) <= 0.5 / damping * (1 + 1e-9)


@pytest.mark.parametrize("shape", [(3, 7), (7, 3), (5, 5), (1, 4)])
@pytest.mark.parametrize("unit", [1e-3, 1.0, 1e3])
def test_an_error_shrinks_under_the_scaled_transpose(shape: tuple[int, int], unit: float) -> None:
    """At a gain of one no part of an error overshoots and the part moved best is gone; from two on one part grows."""
    jacobian = unit * generator().normal(size=shape)
    moved = jacobian @ scaled_transpose(jacobian)
    parts = np.linalg.eigvalsh(moved)
    np.testing.assert_allclose(parts.max(), 1.0, rtol=1e-9)
    assert parts.min() > -1e-9
    left = [np.linalg.norm(np.eye(len(jacobian)) - gain * moved, 2) for gain in (1.0, 1.99, 2.01)]
    assert left[0] < 1.0 + 1e-9
    assert left[1] < 1.0 + 1e-9 < left[2]


def test_what_no_joint_moves_is_left_alone() -> None:
    np.testing.assert_array_equal(scaled_transpose(np.zeros((3, 4))), np.zeros((4, 3)))


def _low_rank(random: np.random.Generator, rows: int, rank: int, columns: int) -> Array:
    return random.normal(size=(rows, rank)) @ random.normal(size=(rank, columns))


@pytest.mark.parametrize(("rows", "rank"), [(1, 1), (3, 3), (6, 2), (9, 5), (3, 0), (12, 8)])
def test_null_space_projector(rows: int, rank: int) -> None:
    columns = 8
    random = generator()
    for _ in range(50):
        jacobian = _low_rank(random, rows, rank, columns)
        projector = null_space_projector(jacobian)
        np.testing.assert_allclose(projector, projector.T, atol=1e-13)
        np.testing.assert_allclose(projector @ projector, projector, atol=1e-12)
        np.testing.assert_allclose(jacobian @ projector, 0.0, atol=1e-11)
        assert np.linalg.matrix_rank(projector, tol=1e-9) == columns - rank


def test_rows_without_content_take_no_freedom_away() -> None:
    jacobian = np.array([[1.0, 0.0, 0.0], [0.0, 1e-9, 0.0]])
    np.testing.assert_allclose(null_space_projector(jacobian), np.diag([0.0, 1.0, 1.0]), atol=1e-12)


def test_inverses_and_projectors_take_batches() -> None:
    jacobians = generator().normal(size=(2, 3, 4, 6))
    jacobians[0, 1] = 0.0
    for place in np.ndindex(2, 3):
        one = jacobians[place]
        np.testing.assert_allclose(null_space_projector(jacobians)[place], null_space_projector(one), atol=1e-13)
        np.testing.assert_allclose(
            damped_pseudo_inverse(0.1, jacobians)[place], damped_pseudo_inverse(0.1, one), atol=1e-13
        )
        np.testing.assert_allclose(scaled_transpose(jacobians)[place], scaled_transpose(one), atol=1e-13)


def test_what_is_across_gradients_is_in_their_null_space() -> None:
    """Of one to four, of all sizes, with one that has vanished and one along others among them."""
    random = generator()
    for count in range(1, 5):
        gradients = random.normal(size=(200, count, 9)) * np.logspace(-7, 3, 200)[:, None, None]
        if count > 2:
            gradients[:50, -1] = gradients[:50, 0] - 2.0 * gradients[:50, 1]
            gradients[50:100, 1] *= 1e-10 / np.linalg.norm(gradients[50:100, 1], axis=-1, keepdims=True)
        long = np.linalg.norm(gradients, axis=-1, keepdims=True)
        projectors = null_space_projector(np.where(long > 1e-9, gradients / long, 0.0))
        found, vectors = directions(*np.moveaxis(gradients, 1, 0)), random.normal(size=(200, 9))
        np.testing.assert_allclose(across(found, vectors), times(projectors, vectors), atol=1e-12)
        np.testing.assert_array_equal(rank_across(found), rank(projectors))
    assert rank_across(directions(gradients[0, 0], gradients[0, 0])) == 8.0
    np.testing.assert_array_equal(across(directions(1e-10 * gradients[0, 0]), vectors[0]), vectors[0])


def test_levels_stand_side_by_side_with_zeros_up_to_the_largest() -> None:
    wide, narrow = generator().normal(size=(2, 4, 3)), generator().normal(size=(2, 4, 2))
    both = side_by_side(2, -1, wide, narrow[0])
    np.testing.assert_array_equal(both[:, 0], wide)
    np.testing.assert_array_equal(both[:, 1], np.broadcast_to(np.pad(narrow[0], ((0, 0), (0, 1))), (2, 4, 3)))
    np.testing.assert_array_equal(side_by_side(2, -1, wide), wide[:, None])


def test_operations_are_what_they_say_in_indices() -> None:
    """And of each of many trials the same as of it alone, to the last bit."""
    random = generator()
    jacobian, vector, point = random.normal(size=(50, 9, 7)), random.normal(size=(50, 9)), random.normal(size=(50, 7))
    blocks, normals = random.normal(size=(50, 3, 3, 7)), unit_vectors(random, 150).reshape(50, 3, 3)
    errors, touching, fingers = random.normal(size=(50, 3, 3)), random.random((50, 3)) < 0.5, random.random((3, 7))
    sizes = np.linalg.norm(errors, axis=-1)
    ahead = np.einsum("tki,tkij->tkj", normals, blocks)
    into = ahead * fingers
    rate = np.where(touching, 0.0, 0.3 / np.maximum((into**2).sum(axis=-1), 0.05))
    step = np.where(touching[..., None], 0.5 * errors / np.maximum(1.0, 0.5 * sizes / 0.2)[..., None], 0.0)
    made = {
        transposed_times: ((jacobian, vector), np.einsum("tij,ti->tj", jacobian, vector)),
        times: ((jacobian, point), np.einsum("tij,tj->ti", jacobian, point)),
        length: ((errors,), sizes),
        along: ((errors, normals), (errors * normals).sum(axis=-1, keepdims=True) * normals),
        longest: ((errors.reshape(50, 9),), sizes.max(axis=-1)),
        excess: ((0.5, errors.reshape(50, 9)), np.maximum(1.0, sizes.max(axis=-1) / 0.5)),
        pressing: ((0.5, 0.2, errors, touching.astype(float)), step),
        approach: ((fingers, 0.3, ahead, touching), np.einsum("tk,tkj->tj", rate, into)),
    }
    for function, (inputs, right) in made.items():
        found = function(*inputs)
        np.testing.assert_allclose(found, right, atol=1e-12)
        for trial in range(50):
            of_trial = [value[trial] if np.shape(value)[:1] == (50,) else value for value in inputs]
            np.testing.assert_array_equal(function(*of_trial), found[trial])
