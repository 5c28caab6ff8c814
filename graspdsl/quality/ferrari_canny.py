"""Ferrari and Canny's measures of a grasp: the largest wrench it resists whatever its direction, and the volume.

C. Ferrari and J. Canny, "Planning optimal grasps", 1992, with their L1 criterion: the normal forces of all contacts sum
to one, so the wrenches are the convex hull of all primitive wrenches together.
"""

from __future__ import annotations

from dataclasses import asdict, dataclass

import numpy as np

from graspdsl.quality.force_closure import force_closure
from graspdsl.quality.grade import NO_CONTACTS, REFERENCE, Found, Grade, Grasp, Metric, Quantity
from graspdsl.quality.wrench_space import DIMENSIONS, WrenchSpace


@dataclass(frozen=True, slots=True)
class FerrariCanny:
    """Both of one hull in the six dimensions of wrenches: the convex hull of the primitive wrenches of all contacts.

    Its axes have no units: forces are over the sum of the normal forces, moments over that sum times the length of the
    wrench space [m], the torque scale. epsilon: the radius of the largest ball about the origin within the hull, zero
    where it does not hold the origin. volume: what the hull fills, whether or not it holds the origin, which is not
    added to it; zero where the hull is flat. With moments per newton of normal force in metres it is the volume times
    length³ [m³]: compare volumes of the same length only. Zeros come with a reason.
    """

    epsilon: Metric
    volume: Metric


def ferrari_canny(space: WrenchSpace) -> FerrariCanny:
    """Epsilon and volume of the convex hull of the primitive wrenches (L1).

    The hull is computed in principal coordinates of equal spread, so that flat hulls lose no digits, and its facets
    are carried back: n·y ≤ b there is (V S⁻¹ n)·w ≤ b here.
    """
    from scipy.spatial import ConvexHull, QhullError

    if len(space.wrenches) == 0:
        return _both(None, NO_CONTACTS)
    closure = force_closure(space)
    if space.rank < DIMENSIONS:
        return _both(0.0, closure.reason)
    count = len(space.wrenches)
    left, values, right = space.decomposition
    try:
        hull = ConvexHull(np.sqrt(count) * left)
    except QhullError:
        flat = "the hull of the wrenches is flat"
        return FerrariCanny(Metric(0.0, closure.reason or flat), Metric(0.0, flat))
    spreads = values / np.sqrt(count)
    volume = Metric(float(hull.volume * spreads.prod()))
    if not closure.closed:
        return FerrariCanny(Metric(0.0, closure.reason), volume)
    normals = (hull.equations[:, :-1] / spreads) @ right
    return FerrariCanny(Metric(float((-hull.equations[:, -1] / np.linalg.norm(normals, axis=1)).min())), volume)


def _both(value: float | None, reason: str) -> FerrariCanny:
    return FerrariCanny(Metric(value, reason), Metric(value, reason))


class FerrariCannyGrade(Grade):
    """Epsilon and volume of a final grasp, with what they depend on: contact model, reference, length [m]."""

    name = "ferrari-canny"
    about = "the largest wrench that the grasp resists in every direction (ε), and the volume of all that it resists"
    definition = (
        "Ferrari and Canny's ε: the radius of the largest ball of wrenches about the origin that the grasp can balance "
        "with contact forces of bounded size; volume: that of the set of all wrenches it can balance."
    )
    title, column = "Ferrari–Canny", "Ferrari-Canny"
    quantities = (Quantity("epsilon", "ε"), Quantity("volume", "volume"))
    by_friction = True

    def of(self, grasp: Grasp) -> Found:
        """Both, with the reason where one is zero or None."""
        space = grasp.wrenches
        found = _both(None, grasp.missing) if grasp.missing else ferrari_canny(space)
        depends = {"model": space.model, "criterion": "L1", "reference": REFERENCE, "length": space.length}
        return {**asdict(found), **depends}
