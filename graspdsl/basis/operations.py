"""The numerical steps between transforms: descent, projection, caps, approach. Leading axes are batches."""

from __future__ import annotations

from typing import Any

import numpy as np

from graspdsl.arrays import Array, Flags, namespace, product
from graspdsl.basis.algebra import length, null_space_projector, tangent_planes


def transposed_times(jacobian: Array, vector: Array) -> Array:
    """Jᵀ v for J (..., d, D) and v (..., d)."""
    return namespace(vector).vecmat(vector, jacobian)


def times(matrix: Array, vector: Array) -> Array:
    """A v for A (..., d, D) and v (..., D)."""
    return namespace(matrix).matvec(matrix, vector)


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
    xp, shape = namespace(rows), (*rows.shape[:-2], 1, 3)
    return xp.concatenate([rows, xp.broadcast_to(last[..., None, :], shape)], axis=-2)


def rank(projector: Array) -> Array:
    """The dimension (...) of what an orthogonal projector (..., D, D) leaves free."""
    dimension: Array = projector.trace(axis1=-2, axis2=-1).round()
    return dimension


def stacked(*matrices: Array) -> Array:
    """Matrices (..., d, D) on top of each other; leading axes broadcast."""
    xp, batch = namespace(matrices[0]), np.broadcast_shapes(*(matrix.shape[:-2] for matrix in matrices))
    return xp.concatenate([xp.broadcast_to(matrix, (*batch, *matrix.shape[-2:])) for matrix in matrices], axis=-2)


def rows_of(mixing: Array, displacement: Array) -> Array:
    """The displacements (..., m, 3) of the resources in a mixing matrix (m, k), from those of the contacts."""
    return product(mixing, by_contact(displacement))


def shared(sharing: Array, jacobian: Array) -> Array:
    """A Jacobian (..., d, c k) by contacts that move together: sharing (k, k) has ones between them."""
    coordinates = np.eye(jacobian.shape[-1] // len(sharing))
    return product(jacobian, np.asarray(np.kron(sharing, coordinates), dtype=np.float64))


def shared_along_frames(sharing: Array, jacobian: Array, frames: Array) -> Array:
    """A Jacobian (..., d, 2k) in coordinates along frames T (..., k, 3, 2), by contacts that move together in space.

    Each takes the part along its own tangent plane: columns Σ_i sharing_ij J_i T_iᵀ T_j, free of the choice of frames.
    """
    blocks = jacobian.reshape(*jacobian.shape[:-1], len(sharing), 2)
    xp = namespace(jacobian)
    together = xp.einsum("...dki,...kai,kj->...dja", blocks, frames, sharing)
    return xp.einsum("...dja,...jai->...dji", together, frames).reshape(jacobian.shape)


def gated(displacement: Array, gate: Array) -> Array:
    """The displacement (..., D) where the gate (...) is one, nothing where it is zero."""
    return displacement * gate[..., None]


def longest(rows: Array) -> Array:
    """The greatest length (...) of the rows of (..., 3m)."""
    greatest: Array = length(by_contact(rows)).max(axis=-1)
    return greatest


def limited(limit: Array | float, vector: Array) -> Array:
    """A vector (..., D), shortened to ``limit`` where it is longer."""
    return vector / namespace(vector).maximum(1.0, length(vector)[..., None] / limit)


def excess(cap: float, displacement: Array) -> Array:
    """How many times the farthest of contact displacements (..., 3k) is as long as ``cap`` [m], at least one: (...)."""
    return namespace(displacement).maximum(1.0, longest(displacement) / cap)


def shortened(displacement: Array, excess: Array) -> Array:
    """Contact displacements (..., 3k), all shortened alike, by how many times (...) they are too long."""
    return displacement / excess[..., None]


def by_displacement(jacobian: Array, frames: Array, radius: Array) -> Array:
    """A Jacobian (..., d, 2k) by surface coordinates as one by displacements, J Tᵀ / r, (..., d, 3k) (Eq. 4.27)."""
    blocks = jacobian.reshape(*jacobian.shape[:-1], -1, 2)
    moved = namespace(frames).einsum("...dkj,...kij->...dki", blocks, frames) / radius
    return moved.reshape(*moved.shape[:-2], -1)


def by_joints(effect: Array, jacobian: Array) -> Array:
    """A Jacobian (..., d, 3k) by displacements of the contacts as one by joints, with theirs (..., k, 3, n)."""
    return product(effect, jacobian.reshape(*jacobian.shape[:-3], -1, jacobian.shape[-1]))


def by_turning(weights: Array, effect: Array, angular_jacobian: Array) -> Array:
    """A Jacobian (..., d, 3) by a turn of all contacts as one by joints: theirs (..., k, 3, n), meaned by weights (k,),
    as contacts of one rigid body turn alike."""
    return effect @ namespace(angular_jacobian).einsum("k,...kij->...ij", weights, angular_jacobian)


def of_the_model_sphere(normals: Array, radius: Array) -> Array:
    """Shape operators (I − n nᵀ) / r [1/m], (..., k, 3, 3), of a sphere that contacts with normals (..., k, 3) touch:
    where the surface is not known."""
    return tangent_planes(normals) / radius


def from_surface(frames: Array, radius: Array, coordinates: Array) -> Array:
    """Displacements (..., k, 3) [m] of surface coordinates (..., k, 2) [rad]: r T ψ, the inverse of Eq. 4.27."""
    return radius * namespace(frames).einsum("...kij,...kj->...ki", frames, coordinates)


def task_projector(*jacobians: Array) -> Array:
    """The projector on the null space of all higher tasks at once: N of their stacked Jacobians."""
    return null_space_projector(stacked(*jacobians))


def directions(*gradients: Array) -> Array:
    """Orthonormal directions (..., m, D) of the m higher gradients, of which N(∇ᵀ) of Eq. 4.19 leaves what is across
    all of them; by Gram and Schmidt.

    A gradient that has all but vanished has no direction, nor has one along those before it: zeros in its place.
    """
    found: list[Array] = []
    for gradient in gradients:
        direction = _direction(gradient, VANISHED)
        for _ in range(2 if found else 0):  # once leaves rounding of what has gone, twice does not
            for other in found:
                direction = direction - namespace(direction).vecdot(direction, other)[..., None] * other
        found.append(_direction(direction, ALONG) if found else direction)
    return found[0][..., None, :] if len(found) == 1 else namespace(found[0]).stack(found, axis=-2)


def across(directions: Array, vector: Array) -> Array:
    """What of a vector (..., D) is across orthonormal directions (..., m, D): N v, without N."""
    return vector - transposed_times(directions, times(directions, vector))


def rank_across(directions: Array) -> Array:
    """The dimension (...) of all that is across directions (..., m, D)."""
    taken: Array = namespace(directions).vecdot(directions, directions).sum(axis=-1)
    dimension: Array = directions.shape[-1] - taken.round()
    return dimension


def _direction(vector: Array, least: float) -> Array:
    """The unit vector (..., D) of a vector; zero of one that is no longer than ``least``."""
    xp, long = namespace(vector), length(vector)[..., None]
    return xp.where(long > least, vector / xp.maximum(long, least), 0.0)


VANISHED = 1e-9  # of a displacement [m, or rad over a weight] a tick
ALONG = 2e-6  # of a direction, that is left of it across others


def pressing(admittance: float, fastest: float, error: Array, touching: Array) -> Array:
    """Displacements (..., m, 3) [m a tick] into the surface for force errors (..., m, 3) [N].

    admittance [m/N a tick] times the error, no more than ``fastest``; nothing for a contact that does not touch.
    """
    step = admittance * error
    return namespace(error).where(touching[..., None] >= 1.0, limited(fastest, step), 0.0)


def approach(fingers: Array, distance: float, into: Array, touching: Flags) -> Array:
    """Joint displacement (..., n) that brings contacts which do not touch nearer by ``distance`` [m a tick].

    Each uses the joints of its own finger alone, fingers (k, n), along its last or predicted normal, into (..., k, n),
    so that the rest of the hand keeps still. A finger that can hardly move that way is not driven fast.
    """
    xp, own = namespace(into), into * fingers
    rate = xp.where(touching, 0.0, distance / xp.maximum(xp.vecdot(own, own), SHORT_REACH))
    return xp.vecmat(rate, own)


SHORT_REACH = 0.05  # squared motion along the normal for a unit of the scaled finger joints


def all_touch(contacts: Array, touching: Flags) -> Array:
    """1.0 where every contact of a set touches, else 0.0, (...); contacts: (k,), nonzero for members of the set."""
    return namespace(touching).where((touching | (contacts == 0.0)).all(axis=-1), 1.0, 0.0)


def row_touches(mixing: Array, touching: Flags) -> Array:
    """(..., m): 1.0 for each row of the mixing matrix (m, k) whose contacts all touch."""
    return namespace(touching).where((touching[..., None, :] | (mixing == 0.0)).all(axis=-1), 1.0, 0.0)


def changes(effect: Array, whole: Array, shortened: Array, alone: Array, *carried_out: Array) -> Array:
    """What commands (..., D) change of what a level senses, by its Jacobian (..., d, D): (..., 4, d).

    What the level ``alone`` would change; then what the ``whole`` command changes besides, by lower levels, by caps,
    which leave what is ``shortened`` of the level alone, and by locked joints, which leave of both the whole and the
    level alone what is ``carried_out``: all, where nothing is said of it.
    """
    xp = namespace(whole)
    whole_left, alone_left = carried_out or (whole, alone)
    taken = (whole_left - whole) - (alone_left - alone) if carried_out else xp.zeros_like(whole)
    causes = xp.stack([alone_left, whole - shortened, shortened - alone, taken], axis=-2)
    return times(effect[..., None, :, :], causes)


def side_by_side(inner: int, axis: int, *arrays: Array) -> Array:
    """One array (..., L, …) of the arrays of L levels, each with so many ``inner`` axes after those of the batch, with
    zeros where one is shorter than another along an axis."""
    xp, widest = namespace(arrays[0]), max(arrays, key=lambda array: array.shape[axis])
    batch = max((array.shape[:-inner] for array in arrays), key=len)
    rows: list[Any] = [slice(None)] * inner
    if len(arrays) == 1:
        only: Array = widest[(..., None, *rows)]
        return only
    if all(type(array) is np.ndarray for array in arrays):
        whole = np.zeros((*batch, len(arrays), *widest.shape[-inner:]))
        for level, array in enumerate(arrays):
            rows[axis] = slice(array.shape[axis])
            whole[(..., level, *rows)] = array
        return whole
    wide = []
    for array in arrays:
        missing = [(0, 0)] * array.ndim
        missing[axis] = (0, widest.shape[axis] - array.shape[axis])
        wide.append(xp.broadcast_to(xp.pad(array, missing), (*batch, *widest.shape[-inner:])))
    return xp.stack(wide, axis=-1 - inner)
