"""Small linear algebra on (..., 3) arrays and Jacobians, written out where numpy is slow on small arrays."""

from __future__ import annotations

import numpy as np

from graspdsl.arrays import Array


def cross(a: Array, b: Array) -> Array:
    """a × b over the last axis; leading axes broadcast."""
    x, y, z = a[..., 0], a[..., 1], a[..., 2]
    u, v, w = b[..., 0], b[..., 1], b[..., 2]
    first = y * w - z * v
    product = np.empty((*first.shape, 3))
    product[..., 0], product[..., 1], product[..., 2] = first, z * u - x * w, x * v - y * u
    return product


def length(vectors: Array) -> Array:
    """The Euclidean norm over the last axis, (...): of each vector the same, whatever others stand beside it."""
    return np.asarray(np.sqrt(np.vecdot(vectors, vectors)))


def skew(a: Array) -> Array:
    """[a]×, the (..., 3, 3) matrices with [a]× b = a × b."""
    matrix = np.zeros((*a.shape, 3))
    matrix[..., 0, 1], matrix[..., 0, 2] = -a[..., 2], a[..., 1]
    matrix[..., 1, 0], matrix[..., 1, 2] = a[..., 2], -a[..., 0]
    matrix[..., 2, 0], matrix[..., 2, 1] = -a[..., 1], a[..., 0]
    return matrix


def along(vectors: Array, normals: Array) -> Array:
    """The parts (..., k, 3) of vectors along unit normals: (v·n) n."""
    return np.asarray(np.vecdot(vectors, normals)[..., None] * normals)


def tangent_frames(normals: Array) -> Array:
    """Two unit vectors that span the tangent plane of each unit normal, as columns: (..., 3, 2).

    A frame without poles and without a trigonometric function: the branch at n_z < 0 keeps the divisor away from zero.
    """
    x, y, z = normals[..., 0], normals[..., 1], normals[..., 2]
    sign = np.where(z >= 0.0, 1.0, -1.0)
    a = -1.0 / (sign + z)
    b = x * y * a
    frames = np.empty((*normals.shape, 2))
    frames[..., 0, 0], frames[..., 1, 0], frames[..., 2, 0] = 1.0 + sign * x * x * a, sign * b, -sign * x
    frames[..., 0, 1], frames[..., 1, 1], frames[..., 2, 1] = b, sign + y * y * a, -y
    return frames


def spherical_frames(normals: Array) -> Array:
    """The chapter's ê_θ, ê_φ at each inward unit normal f = −(cosθ cosφ, sinθ cosφ, sinφ) (Eq. 4.3), (..., 3, 2).

    They turn without limit near the poles φ = ±90°, the z axis of the world.
    """
    flat = np.hypot(normals[..., 0], normals[..., 1])
    safe = np.where(flat > 0.0, flat, 1.0)
    cos, sin = np.where(flat > 0.0, -normals[..., 0] / safe, 1.0), -normals[..., 1] / safe
    up = -normals[..., 2]
    first = np.stack([-sin, cos, np.zeros_like(sin)], axis=-1)
    second = np.stack([-cos * up, -sin * up, flat], axis=-1)
    return np.stack([first, second], axis=-1)


def spherical_stretch(normals: Array) -> Array:
    """(cos φ, 1) at each normal, (..., 2): how far a unit of θ and of φ reaches on the unit sphere (Eq. 4.4)."""
    flat = np.hypot(normals[..., 0], normals[..., 1])
    return np.stack([flat, np.ones_like(flat)], axis=-1)


def in_columns(blocks: Array) -> Array:
    """Blocks (..., k, 3, c), one a contact, side by side: (..., 3, c k)."""
    moved = np.moveaxis(blocks, -3, -2)
    return moved.reshape(*moved.shape[:-2], moved.shape[-2] * moved.shape[-1])


def in_rows(blocks: Array) -> Array:
    """Blocks (..., m, 3, n) on top of each other: (..., 3m, n)."""
    return blocks.reshape(*blocks.shape[:-3], blocks.shape[-3] * blocks.shape[-2], blocks.shape[-1])


def damped_pseudo_inverse(damping: float, jacobian: Array) -> Array:
    """J⁺ = Jᵀ (J Jᵀ + λ² I)⁻¹, (..., n, m) for J (..., m, n)."""
    transposed = np.swapaxes(jacobian, -1, -2)
    gram = jacobian @ transposed + damping**2 * np.eye(jacobian.shape[-2])
    return np.swapaxes(np.linalg.solve(gram, jacobian), -1, -2)


def scaled_transpose(jacobian: Array) -> Array:
    """Jᵀ / σ², (..., n, m) for J (..., m, n) of largest singular value σ: the transpose in place of J⁺ (Eq. 4.20).

    Motion by K Jᵀe leaves (I − K J Jᵀ) e of an error e: its part along the i-th left singular vector is multiplied by
    1 − K σ_i². No part grows while K < 2/σ², and none changes its sign up to K = 1/σ², where the part that the joints
    move best is gone at once and the others are less by σ_i²/σ² of them. So with this transpose a gain of one is the
    largest that does not overshoot, and one of two the limit of stability, whatever the units and the posture.
    """
    largest = np.linalg.norm(jacobian, ord=2, axis=(-2, -1))[..., None, None]
    scaled: Array = np.swapaxes(jacobian, -1, -2) / np.where(largest > 0.0, largest, 1.0) ** 2
    return scaled


def null_space_projector(jacobian: Array, cutoff: float = 1e-6) -> Array:
    """N = I − J⁺J, (..., n, n), the orthogonal projector on the null space of J (..., m, n).

    Singular values below ``cutoff`` times the largest count as zero, so rows without content do not take freedom away.
    """
    _, values, rows = np.linalg.svd(jacobian, full_matrices=False)
    kept = values > np.maximum(cutoff * values[..., :1], 1e-12)
    basis = rows * kept[..., None]
    result: Array = np.eye(jacobian.shape[-1]) - np.swapaxes(basis, -1, -2) @ basis
    return result
