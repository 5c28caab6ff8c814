"""Small linear algebra on (..., 3) arrays and Jacobians, written out where numpy is slow on small arrays."""

from __future__ import annotations

import numpy as np

from graspdsl.arrays import Array, namespace, packed, product, solved

EYE = np.eye(3)


def cross(a: Array, b: Array) -> Array:
    """a × b over the last axis; leading axes broadcast."""
    x, y, z = a[..., 0], a[..., 1], a[..., 2]
    u, v, w = b[..., 0], b[..., 1], b[..., 2]
    return packed(y * w - z * v, z * u - x * w, x * v - y * u)


def length(vectors: Array) -> Array:
    """The Euclidean norm over the last axis, (...): of each vector the same, whatever others stand beside it."""
    xp = namespace(vectors)
    return xp.sqrt(xp.vecdot(vectors, vectors))


def skew(a: Array) -> Array:
    """[a]×, the (..., 3, 3) matrices with [a]× b = a × b."""
    x, y, z = a[..., 0], a[..., 1], a[..., 2]
    none = namespace(a).zeros_like(x)
    return packed(none, -z, y, z, none, -x, -y, x, none).reshape(*a.shape, 3)


def along(vectors: Array, normals: Array) -> Array:
    """The parts (..., k, 3) of vectors along unit normals: (v·n) n."""
    return namespace(vectors).vecdot(vectors, normals)[..., None] * normals


def tangent_planes(normals: Array) -> Array:
    """I − n nᵀ, the (..., 3, 3) projectors on the tangent planes of unit normals: T Tᵀ of any frame T of theirs."""
    return EYE - normals[..., :, None] * normals[..., None, :]


def tangent_frames(normals: Array) -> Array:
    """Two unit vectors that span the tangent plane of each unit normal, as columns: (..., 3, 2).

    A frame without poles and without a trigonometric function: the branch at n_z < 0 keeps the divisor away from zero.
    """
    x, y, z = normals[..., 0], normals[..., 1], normals[..., 2]
    sign = namespace(normals).where(z >= 0.0, 1.0, -1.0)
    a = -1.0 / (sign + z)
    b = x * y * a
    frames = packed(1.0 + sign * x * x * a, b, sign * b, sign + y * y * a, -sign * x, -y)
    return frames.reshape(*normals.shape, 2)


def spherical_frames(normals: Array) -> Array:
    """The chapter's ê_θ, ê_φ at each inward unit normal f = −(cosθ cosφ, sinθ cosφ, sinφ) (Eq. 4.3), (..., 3, 2).

    They turn without limit near the poles φ = ±90°, the z axis of the world.
    """
    xp = namespace(normals)
    flat = xp.hypot(normals[..., 0], normals[..., 1])
    safe = xp.where(flat > 0.0, flat, 1.0)
    cos, sin = xp.where(flat > 0.0, -normals[..., 0] / safe, 1.0), -normals[..., 1] / safe
    up = -normals[..., 2]
    return packed(-sin, -cos * up, cos, -sin * up, xp.zeros_like(sin), flat).reshape(*normals.shape, 2)


def spherical_stretch(normals: Array) -> Array:
    """(cos φ, 1) at each normal, (..., 2): how far a unit of θ and of φ reaches on the unit sphere (Eq. 4.4)."""
    xp = namespace(normals)
    flat = xp.hypot(normals[..., 0], normals[..., 1])
    return packed(flat, xp.ones_like(flat))


def in_columns(blocks: Array) -> Array:
    """Blocks (..., k, 3, c), one a contact, side by side: (..., 3, c k)."""
    moved = namespace(blocks).swapaxes(blocks, -3, -2)
    return moved.reshape(*moved.shape[:-2], moved.shape[-2] * moved.shape[-1])


def in_rows(blocks: Array) -> Array:
    """Blocks (..., m, 3, n) on top of each other: (..., 3m, n)."""
    return blocks.reshape(*blocks.shape[:-3], blocks.shape[-3] * blocks.shape[-2], blocks.shape[-1])


def damped_pseudo_inverse(damping: float, jacobian: Array) -> Array:
    """J⁺ = Jᵀ (J Jᵀ + λ² I)⁻¹, (..., n, m) for J (..., m, n)."""
    xp = namespace(jacobian)
    gram = product(jacobian, xp.swapaxes(jacobian, -1, -2)) + damping**2 * np.eye(jacobian.shape[-2])
    return xp.swapaxes(solved(gram, jacobian), -1, -2)


def pseudo_inverse(jacobian: Array) -> Array:
    """J⁺, (..., n, m) for J (..., m, n)."""
    return namespace(jacobian).linalg.pinv(jacobian)


def scaled_transpose(jacobian: Array) -> Array:
    """Jᵀ / σ², (..., n, m) for J (..., m, n) of largest singular value σ: the transpose in place of J⁺ (Eq. 4.20).

    Motion by K Jᵀe leaves (I − K J Jᵀ) e of an error e: its part along the i-th left singular vector is multiplied by
    1 − K σ_i². No part grows while K < 2/σ², and none changes its sign up to K = 1/σ², where the part that the joints
    move best is gone at once and the others are less by σ_i²/σ² of them. So with this transpose a gain of one is the
    largest that does not overshoot, and one of two the limit of stability, whatever the units and the posture.
    """
    xp = namespace(jacobian)
    largest = xp.linalg.norm(jacobian, ord=2, axis=(-2, -1))[..., None, None]
    return xp.swapaxes(jacobian, -1, -2) / xp.where(largest > 0.0, largest, 1.0) ** 2


def null_space_projector(jacobian: Array, cutoff: float = 1e-6) -> Array:
    """N = I − J⁺J, (..., n, n), the orthogonal projector on the null space of J (..., m, n).

    Singular values below ``cutoff`` times the largest count as zero, so rows without content do not take freedom away.
    """
    xp = namespace(jacobian)
    _, values, rows = xp.linalg.svd(jacobian, full_matrices=False)
    kept = values > xp.maximum(cutoff * values[..., :1], 1e-12)
    basis = rows * kept[..., None]
    return np.eye(jacobian.shape[-1]) - product(xp.swapaxes(basis, -1, -2), basis)
