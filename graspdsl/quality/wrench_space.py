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
    """The primitive wrenches of a grasp.

    wrenches: (m, 6), force (1) for a unit normal force and moment over ``length`` (1) about ``reference`` (3,) [m];
    length [m]: the characteristic length, which makes moments and forces comparable. model: the contact model in words.
    """

    wrenches: Array
    reference: Array
    length: float
    model: str

    @cached_property
    def decomposition(self) -> tuple[Array, Array, Array]:
        """U (m, r), singular values (r,) and Vᵀ (r, 6) of the wrenches, r their rank."""
        if len(self.wrenches) == 0:
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
    """The primitive wrenches of contacts.

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
    if length is None:
        length = float(np.linalg.norm(levers, axis=1).max(initial=0.0)) or 1.0
    if not 0.0 < length < np.inf:
        raise ValueError(f"a characteristic length is above zero, found {length}")
    frames = contact_frames(levers / length, normals / sizes[:, None])
    generators = model.generators()
    forces = np.einsum("mc,kci->kmi", generators[:, :3], frames)
    torsions = np.einsum("m,ki->kmi", generators[:, 3], frames[:, 0])
    moments = (cross(levers[:, None], forces) + torsions) / length
    wrenches = np.concatenate([forces, moments], axis=-1).reshape(-1, DIMENSIONS)
    return WrenchSpace(wrenches, reference, length, model.name)


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
