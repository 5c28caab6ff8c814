"""Moments of inertia that the engine would not take: mended within the digits of a file, refused beyond."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from xml.etree import ElementTree

import numpy as np

from graspdsl.arrays import Array
from graspdsl.hands.articulated_inertia import (
    MOMENTS,
    FrameJoint,
    axis_of,
    driven_inertias,
    inertia_tensor,
    mass_of,
    pose_of,
)
from graspdsl.hands.kinematic_tree import KinematicTree
from graspdsl.hands.model_joints import CheckedJoint
from graspdsl.hands.urdf_check import UrdfCheck
from graspdsl.hands.urdf_rules import FIXED, HINGES, ROTATING

ROUNDING = 1e-2  # of the largest principal moment: what three digits leave open
LEAST = 1e-9  # of the largest principal moment, of the copy for the engine
APART = 1e-10  # of the largest moment: the engine compares without tolerance
AS_GOOD_AS_NONE = 1e-8  # of the greatest inertia that a joint moves
NONE = 1e-15  # kg m² or kg; the engine holds a joint still below 2.2e-16


def check_inertias(
    whole: KinematicTree,
    root: str,
    links: Mapping[str, ElementTree.Element],
    joints: Mapping[str, CheckedJoint],
    check: UrdfCheck,
) -> None:
    """Hold the inertias of checked links and joints against what the engine can move, and mend what is only rounded.

    A joint that moves needs mass behind it, and inertia about its axis: else the engine holds it still. It takes
    moments for zero of which one is negative or above the sum of the others. What hangs on links and joints that have
    faults already is passed over.
    """
    moving = {
        name: checked for name, checked in joints.items() if checked.joint.kind in HINGES and name not in check.unsound
    }
    turning = [checked.joint.child for checked in moving.values() if checked.joint.kind in ROTATING]
    turned = {link for child in turning for link in whole.below(child)}
    unsound = set(check.unsound)
    for name, link in links.items():
        if name not in unsound:
            before = len(check.found)
            _check_moments(whole.links[name], link, name in turned and mass_of(link) > 0.0, check)
            if len(check.found) > before:
                unsound.add(name)
    weighed = {name: ElementTree.Element("link") if name in unsound else link for name, link in links.items()}
    frames = {name: _frame(checked, sound=name not in check.unsound) for name, checked in joints.items()}
    for name, driven in driven_inertias(weighed, frames, root).items():
        joint = moving[name].joint
        below = whole.below(joint.child)
        if unsound & (below | {inner for inner, found in joints.items() if found.joint.parent in below}):
            continue
        if not any(mass_of(links[link]) > 0.0 for link in below):
            message = f"the joint {name} moves links without mass"
            check.fault(moving[name].element, "no-mass", message, f"give {joint.child} an <inertial> with its mass")
            continue
        if driven.articulated > max(AS_GOOD_AS_NONE * driven.greatest, NONE):
            continue
        turns = joint.kind in ROTATING
        what = "turns links without inertia about its axis" if turns else "moves links without mass along its axis"
        message = f"the joint {name} {what}: the engine would hold it still"
        check.fault(moving[name].element, "wrong-inertia", message, f"work out the inertia of {joint.child}")


def _check_moments(element: ElementTree.Element, link: ElementTree.Element, turned: bool, check: UrdfCheck) -> None:
    """Complain about the moments of a link, at its <inertia> in the file; or mend those of its copy."""
    inertia, owner = link.find("inertial/inertia"), f"the link {link.get('name', '')}"
    at = element.find("inertial/inertia")
    if inertia is None or at is None:
        return
    tensor = inertia_tensor(link)
    moments, axes = np.linalg.eigh(tensor)
    least, middle, most = (float(moment) for moment in moments)
    principal = f"its principal moments of inertia are {least:.3g}, {middle:.3g} and {most:.3g} kg m²"
    if most == 0.0:
        if turned:
            check.fault(element, "wrong-inertia", f"{owner} has a mass but no inertia", "work it out from its shape")
    elif least < -ROUNDING * most:
        message = f"{owner}: {principal}, where none may be negative"
        check.fault(at, "wrong-inertia", message, "make the products of inertia smaller")
    elif most > least + middle + ROUNDING * most:
        message = f"{owner}: {principal}: no body has one above the sum of the others, and the engine takes all for 0"
        (check.fault if turned else check.warn)(at, "wrong-inertia", message, "work them out anew from the shape")
    elif least < LEAST * most or most > (1.0 - APART) * (least + middle):
        # What is left as it is stays as written, to the last digit.
        for key, value in zip(MOMENTS, _six(_apart(moments), axes), strict=True):
            inertia.set(key, repr(value))


def _apart(moments: Array) -> Array:
    """The nearest principal moments (3,), the least first, that the engine takes for those of a body."""
    least, middle, most = moments
    least = max(least, LEAST * most)
    middle = max(middle, least)
    return np.array([least, middle, min(most, (1.0 - APART) * (least + middle))])


def _six(moments: Array, axes: Array) -> Iterator[float]:
    (xx, xy, xz), (_, yy, yz), (_, _, zz) = (axes * moments @ axes.T).tolist()
    return iter((xx, yy, zz, xy, xz, yz))


def _frame(checked: CheckedJoint, sound: bool) -> FrameJoint:
    along = np.zeros(6)
    if sound and checked.joint.kind != FIXED:
        along[slice(0, 3) if checked.joint.kind in ROTATING else slice(3, 6)] = axis_of(checked.made)
    return FrameJoint(checked.joint.parent, checked.joint.child, *pose_of(checked.made), along)
