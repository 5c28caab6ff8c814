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
        "on any force and moments over the largest distance of a contact from the centre of mass."
    )
    column = "isotropy"
    quantities = (Quantity("index", "isotropy index"),)

    def of(self, grasp: Grasp) -> Found:
        """The index (1), with the reason where it is zero or None."""
        if grasp.missing:
            return {"index": {"value": None, "reason": grasp.missing}}
        matrix = grasp_matrix(grasp.points, grasp.centre_of_mass)
        rank = np.linalg.matrix_rank(matrix)
        if rank < 6:
            return {"index": {"value": 0.0, "reason": f"contact forces span {rank} of 6 dimensions of wrenches"}}
        values = np.linalg.svd(matrix, compute_uv=False)
        return {"index": {"value": float(values[-1] / values[0]), "reason": ""}}


def grasp_matrix(points: Array, centre: Array) -> Array:
    """G (6, 3k): forces at points (k, 3) [m] to the wrench about a centre (3,) [m], moments over the longest lever."""
    levers = points - centre
    length = float(np.linalg.norm(levers, axis=1).max()) or 1.0
    blocks = np.concatenate([np.broadcast_to(np.eye(3), (len(points), 3, 3)), skew(levers / length)], axis=1)
    return np.asarray(np.concatenate(list(blocks), axis=1))
