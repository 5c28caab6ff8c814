"""What is measured of a grasp: residuals, orientation, sensing errors, from the truth where it is known."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from graspdsl.arrays import Array
from graspdsl.basis.algebra import cross
from graspdsl.basis.resources import ContactSet
from graspdsl.worlds.protocol import Observation, Truth

DOWN = np.array([0.0, 0.0, -1.0])


@dataclass(frozen=True, slots=True)
class GraspMeasure:
    """A grasp at one tick.

    force_residual: ‖ρ_f‖ (1), moment_residual: ‖ρ_m‖ [m] about the contacts' centroid; orientation [rad], 0…π/2, of the
    line through two contacts or of the normal of the plane of more, against the object's axis; NaN for one contact.
    """

    force_residual: float
    moment_residual: float
    orientation: float


def true_contacts(observation: Observation, truth: Truth) -> tuple[Array, Array]:
    """Contact points and normals, (k, 3) each: the truth where a contact touches, else what the hand knows."""
    known = np.isfinite(truth.points[:, :1])
    return np.where(known, truth.points, observation.points), np.where(known, truth.normals, observation.normals)


def measure(observation: Observation, truth: Truth, grasp: ContactSet) -> GraspMeasure:
    """The residuals (Eq. 4.1, 4.2 with 4.32) and the orientation (Sec. 4.5.1, 4.5.2) of the present grasp."""
    points, normals = true_contacts(observation, truth)
    if grasp.has_gravity:
        points, normals = np.vstack([points, truth.object_position]), np.vstack([normals, DOWN])
    weights = grasp.weights
    centroid = weights @ points / weights.sum()
    force = weights @ normals
    moment = weights @ cross(points - centroid, normals)
    return GraspMeasure(
        force_residual=float(np.linalg.norm(force)),
        moment_residual=float(np.linalg.norm(moment)),
        orientation=orientation(grasp.matrix @ points, truth.object_axis),
    )


def orientation(points: Array, axis: Array) -> float:
    """The angle [rad], 0…π/2, between an axis (3,) and the line through two points or the normal of the plane of more.

    points: (m, 3). NaN for fewer than two.
    """
    if len(points) < 2:
        return math.nan
    _, _, directions = np.linalg.svd(points - points.mean(axis=0))
    direction = directions[0] if len(points) == 2 else directions[2]
    return math.acos(min(1.0, abs(float(direction @ axis))))


def sensing_errors(observation: Observation, truth: Truth) -> tuple[Array, Array]:
    """Distances [m] of sensed from true contact points and angles [rad] between normals, for contacts that touch."""
    both = observation.touching & np.isfinite(truth.points[:, 0])
    distance = np.linalg.norm((observation.points - truth.points)[both], axis=1)
    sine = np.linalg.norm(cross(observation.normals[both], truth.normals[both]), axis=1)
    cosine = np.einsum("ki,ki->k", observation.normals[both], truth.normals[both])
    return np.asarray(distance), np.arctan2(sine, cosine)
