"""The wrenches that a set of contacts can put on an object, as the edges of their friction cones."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from graspdsl.arrays import Array
from graspdsl.basis.algebra import cross
from graspdsl.quality.contact_models import ContactModel

DIMENSIONS = 6
RANK_TOLERANCE = 1e-8  # of the largest singular value
LEAST_TANGENT = 0.3  # sine of the angle between a normal and what its first tangent is taken from


@dataclass(frozen=True)
class WrenchSpace:
    """The wrenches that contacts can put on an object, per newton of each contact's normal force.

    basis: (k, 4, 6), the wrench of each component of a contact, as its ``model`` has them: force (1) and moment over
    ``length`` (1) about ``reference`` (3,) [m]. length [m]: the torque scale, which makes moments comparable.
    """

    basis: Array
    model: ContactModel
    reference: Array
    length: float

    @cached_property
    def wrenches(self) -> Array:
        """The primitive wrenches (m, 6): of the edges of every contact's model."""
        each: Array = np.einsum("mc,kci->kmi", self.model.generators(), self.basis)
        return each.reshape(-1, DIMENSIONS)

    def support(self, directions: Array) -> Array:
        """How far (n,) the convex hull of all contacts' wrenches reaches along directions (n, 6), with round cones."""
        return np.asarray(self.model.support(np.einsum("kci,ni->nkc", self.basis, directions)).max(axis=1))

    @cached_property
    def decomposition(self) -> tuple[Array, Array, Array]:
        """U (m, r), singular values (r,) and Vᵀ (r, 6) of the wrenches, r their rank."""
        if len(self.basis) == 0:
            return np.zeros((0, 0)), np.zeros(0), np.zeros((0, DIMENSIONS))
        left, values, right = np.linalg.svd(self.wrenches, full_matrices=False)
        kept = values > RANK_TOLERANCE * values[0]
        return left[:, kept], values[kept], right[kept]

    @property
    def rank(self) -> int:
        """How many dimensions the wrenches span."""
        return len(self.decomposition[1])


def wrench_space(
    points: Array,
    normals: Array,
    model: ContactModel,
    *,
    reference: Array | None = None,
    length: float | None = None,
) -> WrenchSpace:
    """The wrenches of contacts.

    points: (k, 3) [m]; normals: (k, 3), into the object, of any length; reference: (3,) [m], what moments are taken
    about, the centroid of the contacts by default (give the object's centre of mass to judge how it can be held);
    length [m]: by default the largest distance of a contact from the reference (1 m where that is zero). Raises
    ValueError for shapes that do not go together, numbers that are not finite, a normal of no length or a length that
    is not above zero.
    """
    points, normals = np.asarray(points, dtype=float), np.asarray(normals, dtype=float)
    if points.ndim != 2 or points.shape[1] != 3 or normals.shape != points.shape:
        raise ValueError(f"points and normals are (k, 3) each, found {points.shape} and {normals.shape}")
    if reference is None:
        reference = points.mean(axis=0) if len(points) else np.zeros(3)
    if not (np.isfinite(points).all() and np.isfinite(normals).all() and np.isfinite(reference).all()):
        raise ValueError("points, normals and the reference are finite numbers")
    sizes = np.linalg.norm(normals, axis=1)
    if (sizes == 0.0).any():
        raise ValueError("a contact's normal has a length")
    levers = points - reference
    longest = float(np.linalg.norm(levers, axis=1).max(initial=0.0)) or 1.0
    if length is None:
        length = longest
    if not 0.0 < length < np.inf:
        raise ValueError(f"a characteristic length is above zero, found {length}")
    frames = contact_frames(levers / longest, normals / sizes[:, None])
    forces = np.concatenate([frames, np.zeros((len(points), 1, 3))], axis=1)
    moments = cross(levers[:, None], forces)
    moments[:, 3] = frames[:, 0]
    return WrenchSpace(np.concatenate([forces, moments / length], axis=-1), model, reference, length)


def contact_frames(levers: Array, normals: Array) -> Array:
    """Right-handed frames (k, 3, 3), rows normal and two tangents, that turn with the grasp as a whole.

    levers: (k, 3) from the reference; normals: (k, 3) unit vectors. The first tangent of each contact is taken from a
    principal direction of levers and normals together, the one that varies least unless it lies along the normal, so
    that a pyramid inside a friction cone does not depend on the axes of the world.
    """
    _, directions = np.linalg.eigh(levers.T @ levers + normals.T @ normals)
    tangents = directions.T[None] - (normals @ directions)[:, :, None] * normals[:, None]  # (k, direction, 3)
    wide = np.linalg.norm(tangents, axis=2) > LEAST_TANGENT
    first = tangents[np.arange(len(normals)), wide.argmax(axis=1)]
    first /= np.linalg.norm(first, axis=1)[:, None]
    return np.stack([normals, first, cross(normals, first)], axis=1)
