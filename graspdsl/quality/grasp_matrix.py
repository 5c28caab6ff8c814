"""The grasp matrix and its least singular value: how far contacts are from some wrench being out of their reach.

Z. Li and S. S. Sastry, "Task-oriented optimal grasping by multifingered robot hands", 1988.
"""

from __future__ import annotations

from dataclasses import asdict

import numpy as np

from graspdsl.arrays import Array
from graspdsl.quality.grade import REFERENCE, Found, Grade, Grasp, Metric, Quantity
from graspdsl.quality.wrench_space import DIMENSIONS, RANK_TOLERANCE, WrenchSpace


def grasp_matrix(space: WrenchSpace) -> Array:
    """G (6, kc): the wrenches of the c components that each of k contacts can pass on, in newtons and, about a soft
    finger's normal, in newtons times the torque scale.

    Three components of a hard contact, its force; one without friction; four of a soft finger.
    """
    units = np.array([1.0, 1.0, 1.0, space.length])[:, None]
    return np.asarray((space.basis * units)[:, : space.model.components].reshape(-1, DIMENSIONS).T)


def least_singular_value(space: WrenchSpace) -> Metric:
    """σ_min of the grasp matrix (1): the least wrench that contact forces of norm one make in any direction, whatever
    their signs and friction; zero, with a reason, where they do not span the space."""
    values = np.linalg.svd(grasp_matrix(space), compute_uv=False)
    rank = int((values > RANK_TOLERANCE * values[0]).sum())
    if rank < DIMENSIONS:
        return Metric(0.0, f"contact forces span {rank} of {DIMENSIONS} dimensions")
    return Metric(float(values[-1]))


class GraspMatrixGrade(Grade):
    """The least singular value of the grasp matrix."""

    name = "grasp-matrix"
    about = "the least singular value of the grasp matrix: the worst direction for contact forces to make a wrench in"
    definition = (
        "Grasp matrix: σ_min is its least singular value, the least wrench that contact forces of norm one make in any "
        "direction; it knows nothing of friction or of which way a contact can push, and is zero where some wrench is "
        "out of reach."
    )
    column = "grasp matrix"
    quantities = (Quantity("least_singular_value", "σ_min", "", ".3g", ".3g"),)

    def of(self, grasp: Grasp) -> Found:
        """σ_min, with the reason where it is zero or None, by which contact model and torque scale."""
        least = Metric(None, grasp.missing) if grasp.missing else least_singular_value(grasp.wrenches)
        return {"least_singular_value": asdict(least), "reference": REFERENCE, **grasp.conventions}
