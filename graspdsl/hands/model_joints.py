"""The joints of a hand's model: of each its kind, limits and mimicry, and its copy for the engine."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from xml.etree import ElementTree

import numpy as np

from graspdsl.angles import roll_pitch_yaw
from graspdsl.basis.rotations import exponential
from graspdsl.hands.articulated_inertia import axis_of, pose_of
from graspdsl.hands.kinematic_tree import TreeJoint
from graspdsl.hands.urdf_check import UrdfCheck
from graspdsl.hands.urdf_rules import CONTINUOUS, CONTINUOUS_JOINT, FIXED, FIXED_JOINT, HINGES, MOVING_JOINT, ROTATING
from graspdsl.places.wording import shortened

UNSTATED_EFFORT = 50.0  # N or N m: the most that drives a joint whose model says nothing of it
MOST_TURN = 6.3  # rad, a turn to either side
NO_LIMITS = {"lower": "0", "upper": "-1"}  # the engine holds a joint at limits of 0 to 0


@dataclass(frozen=True, slots=True)
class Mimic:
    """What a model says of a joint that follows another: its place = multiplier · place of ``joint`` + offset."""

    joint: str
    multiplier: float
    offset: float


@dataclass(frozen=True, slots=True)
class ModelJoint:
    """A joint of a model: its kind, the links it joins, its limits [rad or m], None where it has none, and its mimicry.

    A joint whose limits are equal is fixed there.
    """

    kind: str
    parent: str
    child: str
    limits: tuple[float, float] | None
    mimic: Mimic | None = None


@dataclass(frozen=True, slots=True)
class CheckedJoint:
    """A joint, its element in the file, and its copy for the engine."""

    joint: ModelJoint
    element: ElementTree.Element
    made: ElementTree.Element


def checked_joint(name: str, joint: TreeJoint, check: UrdfCheck) -> CheckedJoint:
    """A joint of the tree, its faults noted in ``check``."""
    if joint.kind != FIXED and joint.kind not in HINGES:
        found = f"is of the type {shortened(joint.kind)!r}" if joint.kind else "has no type"
        hint = f"known types: {', '.join((FIXED, *HINGES))}"
        check.fault(joint.element, "unknown-joint-type", f"the joint {name} {found}", hint)
        check.unsound.add(name)
    rule = {CONTINUOUS: CONTINUOUS_JOINT, FIXED: FIXED_JOINT}.get(joint.kind, MOVING_JOINT)
    made = check.part(name, joint.element, rule, f"the joint {name}")
    kind, limits, mimic = joint.kind, None, None
    if name not in check.unsound:
        mimic = _mimic(made)
        limits = _limits(made)
        if joint.kind == CONTINUOUS:
            limits = None
            for limit in made.findall("limit"):
                limit.attrib.update(NO_LIMITS)
        elif joint.kind in ROTATING and limits is not None and max(map(abs, limits)) > MOST_TURN:
            low, high = limits
            message = f"the joint {name} turns from {low:g} to {high:g} rad, beyond a whole turn"
            degrees = f"if they are degrees, write lower={np.radians(low):.4g} upper={np.radians(high):.4g}"
            check.warn(joint.element, "beyond-a-turn", message, f"limits are in radians; {degrees}")
        elif limits is not None and limits[0] == limits[1]:
            kind, made = FIXED, _locked(made, limits[0])
    return CheckedJoint(ModelJoint(kind, joint.parent, joint.child, limits, mimic), joint.element, made)


def origin_of_motion(name: str, joints: Mapping[str, ModelJoint]) -> Mimic:
    """The joint that a joint follows in the end, by its mimicry and that of those it follows: itself when it has none.

    Joints that mimic one another in a cycle follow the last one of it.
    """
    whole, seen = Mimic(name, 1.0, 0.0), {name}
    while (joint := joints.get(whole.joint)) is not None and joint.mimic is not None and joint.mimic.joint not in seen:
        mimic = joint.mimic
        seen.add(mimic.joint)
        offset = whole.multiplier * mimic.offset + whole.offset
        whole = Mimic(mimic.joint, whole.multiplier * mimic.multiplier, offset)
    return whole


def _limits(made: ElementTree.Element) -> tuple[float, float] | None:
    limit = made.find("limit")
    return None if limit is None else (float(limit.get("lower", "0")), float(limit.get("upper", "0")))


def _mimic(made: ElementTree.Element) -> Mimic | None:
    """What a copied joint says of its mimicry, which the engine does not know: taken out of it."""
    mimic = made.find("mimic")
    if mimic is None:
        return None
    made.remove(mimic)
    return Mimic(mimic.get("joint", ""), float(mimic.get("multiplier", "1")), float(mimic.get("offset", "0")))


def _locked(made: ElementTree.Element, place: float) -> ElementTree.Element:
    """The fixed joint that stands where one does that has no room to move."""
    fixed = ElementTree.Element("joint", name=made.get("name", ""), type=FIXED)
    fixed.extend(end for end in made if end.tag in ("parent", "child"))
    position, rotation = pose_of(made)
    move = place * axis_of(made)
    if made.get("type") in ROTATING:
        rotation = rotation @ exponential(move)
    else:
        position = position + rotation @ move
    numbers = {"xyz": position, "rpy": np.array(roll_pitch_yaw(rotation))}
    origin = {key: " ".join(map(repr, values.tolist())) for key, values in numbers.items()}
    ElementTree.SubElement(fixed, "origin", origin)
    return fixed
