"""Ferrari and Canny's measures of a grasp: the largest wrench it resists whatever its direction, and the volume.

C. Ferrari and J. Canny, "Planning optimal grasps", 1992, with their L1 criterion: the normal forces of all contacts sum
to one, so the wrenches are the convex hull of all primitive wrenches together.
"""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import TYPE_CHECKING

import numpy as np

from graspdsl.arrays import Array
from graspdsl.quality.force_closure import force_closure
from graspdsl.quality.grade import NO_CONTACTS, REFERENCE, Found, Grade, Grasp, Metric, Quantity
from graspdsl.quality.wrench_space import DIMENSIONS, RANK_TOLERANCE, WrenchSpace

if TYPE_CHECKING:
    from scipy.spatial import ConvexHull


@dataclass(frozen=True, slots=True)
class FerrariCanny:
    """All of one hull in the six dimensions of wrenches: the convex hull of the primitive wrenches of all contacts.

    Its axes have no units: forces are over the sum of the normal forces, moments over that sum times the length of the
    wrench space [m], the torque scale. epsilon: the radius of the largest ball about the origin within the hull, zero
    where it does not hold the origin. shortfall: the share of the epsilon of round cones by which that of the pyramids
    within them may be too small, at most; None without an epsilon above zero. volume: what the hull fills, whether or
    not it holds the origin, which is not added to it; zero where the hull is flat. With moments per newton of normal
    force in metres it is the volume times length³ [m³]: compare volumes of the same length only. Zeros come with a
    reason.
    """

    epsilon: Metric
    shortfall: Metric
    volume: Metric


def ferrari_canny(space: WrenchSpace) -> FerrariCanny:
    """Epsilon, what its pyramids leave out, and volume of the convex hull of the primitive wrenches (L1).

    The hull is computed in principal coordinates of equal spread, so that flat hulls lose no digits, and its facets
    are carried back: n·y ≤ b there is (V S⁻¹ n)·w ≤ b here. Epsilon with round cones is the least reach h(d) of theirs
    over all unit vectors d, hence at most the least over the normals of the facets, and at least that of the pyramids.
    """
    if len(space.basis) == 0:
        return _all(None, NO_CONTACTS)
    closure = force_closure(space)
    if space.rank < DIMENSIONS:
        return _all(0.0, closure.reason)
    left, values, right = space.decomposition
    spread = np.sqrt(len(left))
    coordinates, spreads = spread * left, values / spread
    if np.linalg.matrix_rank(coordinates - coordinates[0], tol=RANK_TOLERANCE * spread) < DIMENSIONS:
        return _all(0.0, closure.reason, Metric(0.0, "the hull of the wrenches is flat"))
    hull = _hull(coordinates)
    volume = Metric(float(hull.volume * spreads.prod()))
    if not closure.closed:
        return _all(0.0, closure.reason, volume)
    normals = (hull.equations[:, :-1] / spreads) @ right
    lengths = np.linalg.norm(normals, axis=1)
    epsilon = float((-hull.equations[:, -1] / lengths).min())
    most = float(space.support(normals / lengths[:, None]).min())
    return FerrariCanny(Metric(epsilon), Metric(max(0.0, 1.0 - epsilon / most)), volume)


def _hull(points: Array) -> ConvexHull:
    """The hull of points (m, 6); shaken by some 1e-10 where many lie on one facet and rounding has confused it."""
    from scipy.spatial import ConvexHull, QhullError

    try:
        return ConvexHull(points)
    except QhullError:
        return ConvexHull(points, qhull_options="QJ")


def _all(value: float | None, reason: str, volume: Metric | None = None) -> FerrariCanny:
    return FerrariCanny(Metric(value, reason), Metric(None, reason), volume or Metric(value, reason))


class FerrariCannyGrade(Grade):
    """Epsilon and volume of a final grasp, with what they depend on: contact model, reference, torque scale."""

    name = "ferrari-canny"
    about = "the largest wrench that the grasp resists in every direction (ε), and the volume of all that it resists"
    definition = (
        "Ferrari and Canny's ε: the radius of the largest ball of wrenches about the origin that the grasp can balance "
        "with contact forces of bounded size; volume: that of the set of all wrenches it can balance. Pyramids within "
        "the friction cones stand in for them, and leave out no more of the ε of round cones than is said."
    )
    title, column = "Ferrari–Canny", "Ferrari-Canny"
    quantities = (
        Quantity("epsilon", "ε"),
        Quantity("shortfall", "share of ε left out by pyramids, at most", "", ".3f", ".3f"),
        Quantity("volume", "volume"),
    )
    by_friction = True

    def of(self, grasp: Grasp) -> Found:
        """All three, with the reason where one is zero or None."""
        found = _all(None, grasp.missing) if grasp.missing else ferrari_canny(grasp.wrenches)
        return {**asdict(found), "criterion": "L1", "reference": REFERENCE, **grasp.conventions}
