"""Force closure: whether contact forces can balance any wrench, by linear programming."""

from __future__ import annotations

from dataclasses import asdict, dataclass

import numpy as np

from graspdsl.arrays import Array
from graspdsl.quality.grade import NO_CONTACTS, Found, Grade, Grasp, Metric, Quantity
from graspdsl.quality.wrench_space import DIMENSIONS, WrenchSpace

MARGIN_TOLERANCE = 1e-6  # ten times that of the solver


@dataclass(frozen=True, slots=True)
class ForceClosure:
    """Whether a grasp is closed, by how much, and if not why.

    margin: the largest share t of an even spread of weights that every primitive wrench can have in a balance
    Σ λᵢ wᵢ = 0, Σ λᵢ = 1, λᵢ ≥ t/m: above 0 for closure, 1 for even weights, None where there is no balance at all or
    the wrenches do not span the space. It is the min-weight metric of A. H. Li et al., "FRoGGeR: Fast robust grasp
    generation via the min-weight metric", 2023, over its largest value 1/m. No scale of moments changes it, for what
    balances in one balances in another.
    """

    closed: bool
    margin: float | None
    reason: str = ""

    def __bool__(self) -> bool:
        return self.closed


def force_closure(space: WrenchSpace) -> ForceClosure:
    """Whether the origin lies strictly inside the convex hull of the primitive wrenches.

    It does if and only if they span all six dimensions and balance with weights that are all positive. The program
    runs in the principal coordinates of the wrenches, where each has the same spread.
    """
    count = len(space.wrenches)
    if count == 0:
        return ForceClosure(False, None, NO_CONTACTS)
    if _in_half_space(space.wrenches[:, :3]):
        return ForceClosure(False, None, "all forces in one half space")
    if space.rank < DIMENSIONS:
        return ForceClosure(False, None, f"wrenches span {space.rank} of {DIMENSIONS} dimensions")
    coordinates = np.sqrt(count) * space.decomposition[0]
    margin = _evenest_balance(coordinates)
    if margin is None or margin < -MARGIN_TOLERANCE:
        return ForceClosure(False, margin, "all wrenches in one half space")
    if margin <= MARGIN_TOLERANCE:
        return ForceClosure(False, margin, "no wrench to spare: the origin is on the boundary of the hull")
    return ForceClosure(True, margin)


def _in_half_space(vectors: Array) -> bool:
    """Whether some direction d has d·v > 0 for all vectors (m, n): maximise s with d·v ≥ s, |dᵢ| ≤ 1."""
    from scipy.optimize import linprog

    count, size = vectors.shape
    answer = linprog(
        np.append(np.zeros(size), -1.0),
        A_ub=np.column_stack([-vectors, np.ones(count)]),
        b_ub=np.zeros(count),
        bounds=[(-1.0, 1.0)] * size + [(None, None)],
        method="highs",
    )
    return answer.x is not None and bool(answer.x[-1] > MARGIN_TOLERANCE)


def _evenest_balance(vectors: Array) -> float | None:
    """The largest t with Σ λᵢ vᵢ = 0, Σ λᵢ = 1, λᵢ ≥ t/m for vectors (m, n); None where no weights sum to zero.

    With λᵢ = (sᵢ + t)/m it is a program in sᵢ ≥ 0 and t.
    """
    from scipy.optimize import linprog

    count = len(vectors)
    homogeneous = np.column_stack([vectors, np.ones(count)]).T
    answer = linprog(
        np.append(np.zeros(count), -1.0),
        A_eq=np.column_stack([homogeneous, homogeneous.sum(axis=1)]),
        b_eq=np.append(np.zeros(vectors.shape[1]), count),
        bounds=[(0.0, None)] * count + [(None, None)],
        method="highs",
    )
    return None if answer.x is None else float(answer.x[-1])


class ForceClosureGrade(Grade):
    """Force closure of a final grasp."""

    name = "force-closure"
    about = "whether the contacts' friction cones can balance any wrench on the object, by linear programming"
    definition = (
        "Force closure: the contacts' friction cones can balance any wrench on the object. Its margin: how much every "
        "edge of the cones can be pressed along in one balance of all, as a share of pressing evenly: 1 where all "
        "press alike, above 0 where and only where the grasp is closed, whatever the torque scale."
    )
    passed = "closed"
    column = "force closure"
    verdict = "force_closure"
    quantities = (Quantity("margin", "margin"),)
    by_friction = True

    def of(self, grasp: Grasp) -> Found:
        """Closed or not, by what margin, and if not why; of how many contacts, by which contact model."""
        found = ForceClosure(False, None, grasp.missing) if grasp.missing else force_closure(grasp.wrenches)
        margin = asdict(Metric(found.margin, found.reason))
        return {**asdict(found), "margin": margin, "contacts": len(grasp.points), **grasp.conventions}
