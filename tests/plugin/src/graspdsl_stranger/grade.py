"""A grade: how evenly a grasp can push and twist, whatever the direction."""

from __future__ import annotations

import numpy as np

from graspdsl.arrays import Array
from graspdsl.basis.algebra import skew
from graspdsl.quality.grade import Found, Grade, Grasp, Quantity


class IsotropyGrade(Grade):
    """The grasp isotropy index, σ_min/σ_max of the grasp matrix (Roa and Suárez 2015)."""

    name = "isotropy"
    about = "how evenly the contact forces add up to wrenches in all directions (1 is best)"
    definition = (
        "Grasp isotropy index: the least singular value of the grasp matrix over the largest, for contacts that pass "
        "on any force and moments over the torque scale of the run."
    )
    column = "isotropy"
    quantities = (Quantity("index", "isotropy index"),)

    def of(self, grasp: Grasp) -> Found:
        """The index (1), with the reason where it is zero or None."""
        if grasp.missing:
            return {"index": {"value": None, "reason": grasp.missing}}
        matrix = grasp_matrix((grasp.points - grasp.centre_of_mass) / grasp.torque_scale)
        rank = np.linalg.matrix_rank(matrix)
        if rank < 6:
            return {"index": {"value": 0.0, "reason": f"contact forces span {rank} of 6 dimensions of wrenches"}}
        values = np.linalg.svd(matrix, compute_uv=False)
        return {"index": {"value": float(values[-1] / values[0]), "reason": ""}}


def grasp_matrix(levers: Array) -> Array:
    """G (6, 3k): forces at levers (k, 3) (1), those about the centre of mass over the torque scale, to the wrench."""
    blocks = np.concatenate([np.broadcast_to(np.eye(3), (len(levers), 3, 3)), skew(levers)], axis=1)
    return np.asarray(np.concatenate(list(blocks), axis=1))
