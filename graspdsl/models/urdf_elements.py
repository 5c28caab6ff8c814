"""What stands in the elements of the text of a URDF."""

from __future__ import annotations

from xml.etree import ElementTree

import numpy as np

from graspdsl.angles import turned_by_angles
from graspdsl.arrays import Array

ORIGIN = {"xyz": "0 0 0", "rpy": "0 0 0"}


def pose_of(element: ElementTree.Element) -> tuple[Array, Array]:
    """The place (3,) [m] and the rotation (3, 3) of the <origin> in an element of such a text."""
    origin = element.find("origin")
    numbers = ORIGIN if origin is None else {**ORIGIN, **origin.attrib}
    place, (roll, pitch, yaw) = (np.array(numbers[key].split(), dtype=float) for key in ORIGIN)
    return place, turned_by_angles((roll, pitch, yaw))


def axis_of(joint: ElementTree.Element) -> Array:
    """The axis (3,) of a joint, in its own frame."""
    axis = joint.find("axis")
    return np.array(["1", "0", "0"] if axis is None else axis.get("xyz", "").split(), dtype=float)


def mass_of(link: ElementTree.Element) -> float:
    """The mass [kg] of a link, zero of one that says nothing of it."""
    mass = link.find("inertial/mass")
    return 0.0 if mass is None else float(mass.get("value", "0"))
