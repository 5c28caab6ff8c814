"""The numerical steps between transforms: descent, projection, caps, approach. Leading axes are batches."""

from __future__ import annotations

import numpy as np

from graspdsl.arrays import Array, Flags
from graspdsl.basis.algebra import length, null_space_projector


def transposed_times(jacobian: Array, vector: Array) -> Array:
    """Jᵀ v for J (..., d, D) and v (..., d)."""
    return np.asarray(np.vecmat(vector, jacobian))


def times(matrix: Array, vector: Array) -> Array:
    """A v for A (..., d, D) and v (..., D)."""
    return np.asarray(np.matvec(matrix, vector))


def flat(rows: Array) -> Array:
    """(..., m, 3) as (..., 3m)."""
    return rows.reshape(*rows.shape[:-2], -1)


def by_contact(vector: Array) -> Array:
    """(..., 3m) as (..., m, 3)."""
    return vector.reshape(*vector.shape[:-1], -1, 3)


def by_surface(vector: Array) -> Array:
    """(..., 2m) as (..., m, 2)."""
    return vector.reshape(*vector.shape[:-1], -1, 2)


def same(value: Array) -> Array:
    """The value itself, under another name."""
    return value


def with_last_row(rows: Array, last: Array) -> Array:
    """Rows (..., k, 3) and one more (3,) or (..., 3) beneath them."""
    shape = (*rows.shape[:-2], 1, 3)
    return np.concatenate([rows, np.broadcast_to(last[..., None, :], shape)], axis=-2)


def rank(projector: Array) -> Array:
    """The dimension (...) of what an orthogonal projector (..., D, D) leaves free."""
    return np.asarray(projector.trace(axis1=-2, axis2=-1).round())


def stacked(*matrices: Array) -> Array:
    """Matrices (..., d, D) on top of each other; leading axes broadcast."""
    batch = np.broadcast_shapes(*(matrix.shape[:-2] for matrix in matrices))
    return np.concatenate([np.broadcast_to(matrix, (*batch, *matrix.shape[-2:])) for matrix in matrices], axis=-2)


def rows_of(mixing: Array, displacement: Array) -> Array:
    """The displacements (..., m, 3) of the resources in a mixing matrix (m, k), from those of the contacts."""
    return np.asarray(mixing @ by_contact(displacement))


def shared(sharing: Array, jacobian: Array) -> Array:
    """A Jacobian (..., d, c k) by contacts that move together: sharing (k, k) has ones between them."""
    coordinates = np.eye(jacobian.shape[-1] // len(sharing))
    return np.asarray(jacobian @ np.kron(sharing, coordinates))


def shared_along_frames(sharing: Array, jacobian: Array, frames: Array) -> Array:
    """A Jacobian (..., d, 2k) in coordinates along frames T (..., k, 3, 2), by contacts that move together in space.

    Each takes the part along its own tangent plane: columns Σ_i sharing_ij J_i T_iᵀ T_j, free of the choice of frames.
    """
    blocks = jacobian.reshape(*jacobian.shape[:-1], len(sharing), 2)
    together = np.einsum("...dki,...kai,kj->...dja", blocks, frames, sharing)
    return np.asarray(np.einsum("...dja,...jai->...dji", together, frames).reshape(jacobian.shape))


def gated(displacement: Array, gate: Array) -> Array:
    """The displacement (..., D) where the gate (...) is one, nothing where it is zero."""
    return np.asarray(displacement * gate[..., None])


def longest(rows: Array) -> Array:
    """The greatest length (...) of the rows of (..., 3m)."""
    return np.asarray(length(by_contact(rows)).max(axis=-1))


def limited(limit: Array | float, vector: Array) -> Array:
    """A vector (..., D), shortened to ``limit`` where it is longer."""
    return np.asarray(vector / np.maximum(1.0, length(vector)[..., None] / limit))


def excess(cap: float, displacement: Array) -> Array:
    """How many times the farthest of contact displacements (..., 3k) is as long as ``cap`` [m], at least one: (...)."""
    return np.asarray(np.maximum(1.0, longest(displacement) / cap))


def shortened(displacement: Array, excess: Array) -> Array:
    """Contact displacements (..., 3k), all shortened alike, by how many times (...) they are too long."""
    return np.asarray(displacement / excess[..., None])


def by_displacement(jacobian: Array, frames: Array, radius: Array) -> Array:
    """A Jacobian (..., d, 2k) by surface coordinates as one by displacements, J Tᵀ / r, (..., d, 3k) (Eq. 4.27)."""
    blocks = jacobian.reshape(*jacobian.shape[:-1], -1, 2)
    moved = np.einsum("...dkj,...kij->...dki", blocks, frames) / radius
    return np.asarray(moved.reshape(*moved.shape[:-2], -1))


def by_joints(effect: Array, jacobian: Array) -> Array:
    """A Jacobian (..., d, 3k) by displacements of the contacts as one by joints, with theirs (..., k, 3, n)."""
    return np.asarray(effect @ jacobian.reshape(*jacobian.shape[:-3], -1, jacobian.shape[-1]))


def by_turning(weights: Array, effect: Array, angular_jacobian: Array) -> Array:
    """A Jacobian (..., d, 3) by a turn of all contacts as one by joints: theirs (..., k, 3, n), meaned by weights (k,),
    as contacts of one rigid body turn alike."""
    return np.asarray(effect @ np.einsum("k,...kij->...ij", weights, angular_jacobian))


def of_the_model_sphere(normals: Array, radius: Array) -> Array:
    """Shape operators (I − n nᵀ) / r [1/m], (..., k, 3, 3), of a sphere that contacts with normals (..., k, 3) touch:
    where the surface is not known."""
    return np.asarray((np.eye(3) - normals[..., :, None] * normals[..., None, :]) / radius)


def from_surface(frames: Array, radius: Array, coordinates: Array) -> Array:
    """Displacements (..., k, 3) [m] of surface coordinates (..., k, 2) [rad]: r T ψ, the inverse of Eq. 4.27."""
    return np.asarray(radius * np.einsum("...kij,...kj->...ki", frames, coordinates))


def task_projector(*jacobians: Array) -> Array:
    """The projector on the null space of all higher tasks at once: N of their stacked Jacobians."""
    return null_space_projector(stacked(*jacobians))


def gradient_projector(*gradients: Array) -> Array:
    """The projector on the null space of all higher gradients at once, N(∇ᵀ) of Eq. 4.19.

    A gradient that has all but vanished has no direction: it is left out of the projector.
    """
    directions = [_direction(gradient) for gradient in gradients]
    if len(directions) > 1:
        return null_space_projector(np.stack(directions, axis=-2))
    (direction,) = directions
    return np.asarray(np.eye(direction.shape[-1]) - direction[..., :, None] * direction[..., None, :])


def _direction(gradient: Array) -> Array:
    """The unit vector (..., D) of a gradient; zero of one that has all but vanished."""
    long = length(gradient)[..., None]
    return np.where(long > VANISHED, gradient / np.maximum(long, VANISHED), 0.0)


VANISHED = 1e-9  # of a displacement [m, or rad over a weight] a tick


def pressing(admittance: float, fastest: float, error: Array, touching: Array) -> Array:
    """Displacements (..., m, 3) [m a tick] into the surface for force errors (..., m, 3) [N].

    admittance [m/N a tick] times the error, no more than ``fastest``; nothing for a contact that does not touch.
    """
    step = admittance * error
    return np.where(touching[..., None] >= 1.0, limited(fastest, step), 0.0)


def approach(fingers: Array, distance: float, jacobian: Array, normals: Array, touching: Flags) -> Array:
    """Joint displacement (..., n) that brings contacts which do not touch nearer by ``distance`` [m a tick].

    Each uses the joints of its own finger alone, fingers (k, n), along its last or predicted normal, so that the rest
    of the hand keeps still. A finger that can hardly move that way is not driven fast.
    """
    into = np.vecmat(normals, jacobian) * fingers
    rate = np.where(touching, 0.0, distance / np.maximum(np.vecdot(into, into), SHORT_REACH))
    return np.asarray(np.vecmat(rate, into))


SHORT_REACH = 0.05  # squared motion along the normal for a unit of the scaled finger joints


def all_touch(contacts: Array, touching: Flags) -> Array:
    """1.0 where every contact of a set touches, else 0.0, (...); contacts: (k,), nonzero for members of the set."""
    return np.asarray((touching | (contacts == 0.0)).all(axis=-1), dtype=float)


def row_touches(mixing: Array, touching: Flags) -> Array:
    """(..., m): 1.0 for each row of the mixing matrix (m, k) whose contacts all touch."""
    return np.asarray((touching[..., None, :] | (mixing == 0.0)).all(axis=-1), dtype=float)
