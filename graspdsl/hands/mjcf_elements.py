"""Elements of URDF that stand for some of MJCF, with the places of these for complaints."""

from __future__ import annotations

from collections.abc import Mapping
from xml.etree import ElementTree

import numpy as np

from graspdsl.angles import roll_pitch_yaw
from graspdsl.arrays import Array
from graspdsl.hands.mjcf_parts import Pose
from graspdsl.places.xml_files import PlacedElement


def add(
    to: ElementTree.Element, tag: str, attributes: Mapping[str, str], source: ElementTree.Element | None = None
) -> ElementTree.Element:
    """A new last element within another, at the line and column of what it stands for, or of that other."""
    made = PlacedElement(tag, dict(attributes))
    at = to if source is None else source
    if isinstance(at, PlacedElement):
        made.line, made.column = at.line, at.column
    to.append(made)
    return made


def add_origin(to: ElementTree.Element, pose: Pose) -> None:
    """Where an element is and how it is turned."""
    rpy = np.array(roll_pitch_yaw(pose.turned.as_matrix()))
    add(to, "origin", {"xyz": as_text(pose.place), "rpy": as_text(rpy)})


def as_text(numbers: Array) -> str:
    """Numbers as an attribute has them."""
    return " ".join(map(repr, numbers.tolist()))
