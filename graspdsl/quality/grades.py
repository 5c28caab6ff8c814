"""What a record says of a grasp's quality, as plain data: the measures in wrench space."""

from __future__ import annotations

from typing import Any

from graspdsl.arrays import Array
from graspdsl.quality.contact_models import HardPoint
from graspdsl.quality.ferrari_canny import ferrari_canny
from graspdsl.quality.force_closure import force_closure
from graspdsl.quality.metric import Metric
from graspdsl.quality.wrench_space import WrenchSpace, wrench_space

REFERENCE = "the object's centre of mass"


def grasp_wrenches(points: Array, normals: Array, centre_of_mass: Array, friction: float) -> WrenchSpace:
    """The wrenches by which the grades judge: hard point contacts, moments about the object's centre of mass.

    points, normals: (k, 3) [m], normals into the object; centre_of_mass: (3,) [m]. Contacts are hard because neither
    world's can twist the object about their normal: to judge tips with a patch, give ``wrench_space`` a SoftFinger.
    """
    return wrench_space(points, normals, HardPoint(friction), reference=centre_of_mass)


def graded_force_closure(space: WrenchSpace, contacts: int) -> dict[str, Any]:
    """Force closure of a number of contacts as plain data."""
    found = force_closure(space)
    return {
        "closed": found.closed,
        "margin": found.margin,
        "reason": found.reason,
        "contacts": contacts,
        "model": space.model,
    }


def graded_ferrari_canny(space: WrenchSpace) -> dict[str, Any]:
    """Epsilon and volume (L1) as plain data, with what they depend on: contact model, reference, length [m]."""
    found = ferrari_canny(space)
    return {
        "epsilon": _plain(found.epsilon),
        "volume": _plain(found.volume),
        "model": space.model,
        "criterion": "L1",
        "reference": REFERENCE,
        "length": space.length,
    }


def _plain(metric: Metric) -> dict[str, Any]:
    return {"value": metric.value, "reason": metric.reason}
