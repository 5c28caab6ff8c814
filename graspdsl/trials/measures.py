"""What is measured of grasps: residuals, orientation, sensing errors, from the truth where it is known.

Leading axes are a batch of trials. Each trial's numbers are the same to the last bit whatever others stand beside it:
so lengths are taken by ``vecdot``, and arcs one by one, for what is faster for many rounds otherwise.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cache

import numpy as np

from graspdsl.arrays import Array, Flags, Rows
from graspdsl.basis.algebra import cross, length
from graspdsl.basis.resources import ContactSet
from graspdsl.worlds.protocol import Observation, Truth

DOWN = np.array([0.0, 0.0, -1.0])


@dataclass(frozen=True, slots=True)
class GraspMeasure:
    """Grasps at one tick: force_residual ‖ρ_f‖ (1) and moment_residual ‖ρ_m‖ [m] about the contacts' centroid, (...).

    points: (..., k, 3) [m] of the contacts, (..., k + 1, 3) with gravity; ``grasp``: the resources; axis: (..., 3) of
    the object.
    """

    force_residual: Array
    moment_residual: Array
    points: Array
    grasp: ContactSet
    axis: Array

    @property
    def orientation(self) -> Array:
        """Of the resources against the object's axis (...) [rad]."""
        return orientation(self.grasp.matrix @ self.points, self.axis)


def true_contacts(observation: Observation, truth: Truth) -> tuple[Array, Array]:
    """Contact points and normals, (..., k, 3) each: the truth where a contact touches, else what the hand knows."""
    known = np.isfinite(truth.points[..., :1])
    if known.all():
        return truth.points, truth.normals
    return np.where(known, truth.points, observation.points), np.where(known, truth.normals, observation.normals)


def with_gravity(points: Array, truth: Truth, grasp: ContactSet) -> Array:
    """Contact points (..., k, 3) and, where γ_g is among the resources of a grasp, where it pulls: the centre of mass
    after them, as the matrix of the grasp has it."""
    return np.concatenate([points, truth.object_position[..., None, :]], axis=-2) if grasp.has_gravity else points


def measure(observation: Observation, truth: Truth, grasp: ContactSet) -> GraspMeasure:
    """The residuals (Eq. 4.1, 4.2 with 4.32) and the orientation (Sec. 4.5.1, 4.5.2) of the present grasps."""
    points, normals = true_contacts(observation, truth)
    points = with_gravity(points, truth, grasp)
    if grasp.has_gravity:
        normals = np.concatenate([normals, np.broadcast_to(DOWN, (*normals.shape[:-2], 1, 3))], axis=-2)
    of_grasp, weights, total = _weighed(grasp)
    chosen, inward = points[..., of_grasp, :], normals[..., of_grasp, :]
    centroid = weights @ chosen / total
    return GraspMeasure(
        force_residual=length(weights @ inward),
        moment_residual=length(weights @ cross(chosen - centroid[..., None, :], inward)),
        points=points,
        grasp=grasp,
        axis=truth.object_axis,
    )


@cache
def _weighed(grasp: ContactSet) -> tuple[Rows | slice, Array, float]:
    """Which contacts weigh anything, their weights, and the sum of these."""
    weights = grasp.weights
    chosen = np.flatnonzero(weights)
    return slice(None) if len(chosen) == len(weights) else chosen, weights[chosen], float(weights.sum())


def orientation(points: Array, axis: Array) -> Array:
    """The angles (...) [rad], 0…π/2, between an axis and the line through two points or the plane normal of more.

    points: (..., m, 3), axis: (..., 3). NaN for fewer than two.
    """
    if points.shape[-2] < 2:
        return np.full(points.shape[:-2], np.nan)
    if points.shape[-2] == 2:
        along = points[..., 1, :] - points[..., 0, :]
        sizes = np.maximum(length(along), np.finfo(float).tiny)
    else:
        along, sizes = np.linalg.svd(points - points.mean(axis=-2, keepdims=True))[2][..., 2, :], np.ones(())
    cosines = np.minimum(1.0, np.abs(np.vecdot(along, axis)) / sizes)
    return np.array([math.acos(cosine) for cosine in cosines.ravel()]).reshape(cosines.shape)


def sensing_errors(observation: Observation, truth: Truth) -> tuple[Flags, Array, Array, Array]:
    """Which contacts touch, by feeling and in truth; the distances [m] of sensed from true contact points; and the sine
    and the cosine of the angles between their normals; (..., k) each."""
    both = observation.touching & np.isfinite(truth.points[..., 0])
    distance = length(observation.points - truth.points)
    sine = length(cross(observation.normals, truth.normals))
    return both, distance, sine, np.asarray(np.vecdot(observation.normals, truth.normals))
