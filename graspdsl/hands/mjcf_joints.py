"""Hinges and slides in MJCF as the joints that URDF has."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from xml.etree import ElementTree

from graspdsl.arrays import Array
from graspdsl.diagnostics import Diagnostic, Severity
from graspdsl.hands.mjcf_compiler import Compiler
from graspdsl.hands.mjcf_elements import add, as_text
from graspdsl.hands.mjcf_parts import Part, Pose
from graspdsl.places.xml_files import place_in

HINGE, SLIDE = "hinge", "slide"
ON_OFF = ("auto", "true", "false")
# What joints are built without, and what that changes.
LEFT_OUT: Mapping[str, str] = {
    "armature": "a joint speeds up faster",
    "frictionloss": "a joint moves more easily",
}


def describe(made: ElementTree.Element, joint: Part, hinge: Pose, compiler: Compiler) -> None:
    """Give a joint of URDF the kind, axis, damping and limits of one of MJCF, which is turned as ``hinge``.

    Raises DiagnosticError for a kind that is not read, and for limits that are none.
    """
    kind = joint.attributes.get("type", HINGE)
    if kind not in (HINGE, SLIDE):
        raise joint.refused(f"the joint is neither a hinge nor a slide, but {kind!r}")
    axis = joint.numbers("axis", "0 0 1", 3)
    axis = hinge.turned.apply(joint.direction("axis", axis) if "axis" in joint.attributes else axis)
    add(made, "axis", {"xyz": as_text(axis)})
    damping = joint.number("damping", "0")
    if damping < 0.0:
        raise joint.refused(f"its damping is negative: {damping:g}", None)
    add(made, "dynamics", {"damping": f"{damping!r}"})
    limits, strength = _limits(joint, "range", "limited", compiler), _strength(joint, compiler)
    made.set("type", "prismatic" if kind == SLIDE else "continuous" if limits is None else "revolute")
    if limits is not None:
        low, high = (compiler.angles.radians(limits) if kind == HINGE else limits).tolist()
        limit = {"lower": f"{low!r}", "upper": f"{high!r}", "effort": f"{strength!r}", "velocity": "10"}
        add(made, "limit", limit)


def _limits(joint: Part, key: str, switch: str, compiler: Compiler) -> Array | None:
    """The ends (2,) of a range that is on, None of one that is off."""
    state = joint.word(switch, ON_OFF)
    ends = joint.numbers(key, "0 0", 2)
    if state == "false":
        return None
    if state == "true" and key not in joint.attributes:
        raise joint.refused(f"it is {switch} and has no {key}", f'give it one: {key}="low high"')
    if state == "auto" and key in joint.attributes and not compiler.autolimits:
        raise joint.refused(f"it has a {key}, but does not say whether it is {switch}", f'write {switch}="true"')
    if ends[0] > ends[1] or (state == "true" and ends[0] == ends[1]):
        raise joint.refused(f"its {key} leaves no room: {as_text(ends)}", "the lower end comes first")
    return ends if ends[0] < ends[1] else None


def _strength(joint: Part, compiler: Compiler) -> float:
    """The most that drives a joint [N or Nm], zero where the file does not say."""
    ends = _limits(joint, "actuatorfrcrange", "actuatorfrclimited", compiler)
    if ends is None:
        return 0.0
    if ends[0] != -ends[1]:
        raise joint.refused("its actuatorfrcrange is not as strong either way", "write it as -a a")
    return float(ends[1])


class LeftOut:
    """What joints say that they are built without: better a hand that moves a little otherwise than none."""

    def __init__(self) -> None:
        self._joints: dict[str, list[tuple[float, Part]]] = {key: [] for key in LEFT_OUT}

    def note(self, joint: Part) -> None:
        """Keep what is left out of a joint. Raises DiagnosticError where it is negative."""
        for key, joints in self._joints.items():
            amount = joint.number(key, "0")
            if amount < 0.0:
                raise joint.refused(f"its {key} is negative: {amount:g}", None)
            if amount > 0.0:
                joints.append((amount, joint))

    def warnings(self) -> Iterator[Diagnostic]:
        """One of each kind, at the joint where it is largest."""
        for key, joints in self._joints.items():
            if joints:
                amount, joint = max(joints, key=lambda kept: kept[0])
                others = f", and that of other joints ({len(joints) - 1})" if len(joints) > 1 else ""
                message = f"{joint.called}: its {key}, {amount:g}, is left out{others}: without it {LEFT_OUT[key]}"
                place = place_in(joint.source.file, joint.element)
                hint = f'write {key}="0" where that is meant'
                yield Diagnostic("left-out-of-joints", f"{place}: {message}", hint=hint, severity=Severity.WARNING)
