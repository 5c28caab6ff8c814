"""What a hand's URDF may say: elements, how often each stands, and the bounds of every number in them.

What is not listed here is left out: nothing reaches the engine unchecked.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field

FIXED = "fixed"
CONTINUOUS = "continuous"
ROTATING = ("revolute", CONTINUOUS)
HINGES = (*ROTATING, "prismatic")
SHAPES = ("box", "sphere", "cylinder", "capsule", "mesh")
MESHES = (".stl", ".obj")  # the engine falls over some files of others

FARTHEST = 10.0  # m
HEAVIEST = 100.0  # kg


@dataclass(frozen=True, slots=True)
class NumberRule:
    """The numbers of an attribute, from ``lowest`` to ``highest``; ``above``: more than ``lowest``.

    ``otherwise`` stands for an attribute that is not there: None where it has to be, empty where it stays out.
    """

    lowest: float
    highest: float
    unit: str = ""
    count: int = 1
    above: bool = False
    otherwise: str | None = None


@dataclass(frozen=True, slots=True)
class ElementRule:
    """What an element has: its numbers, attributes of text, what stands in it, what of that has to and may often.

    One that is only ``drawn`` is left out when something is wrong in it.
    """

    numbers: Mapping[str, NumberRule] = field(default_factory=dict)
    texts: tuple[str, ...] = ()
    children: Mapping[str, ElementRule] = field(default_factory=dict)
    needed: tuple[str, ...] = ()
    many: tuple[str, ...] = ()
    only_one: bool = False
    drawn: bool = False


def _length() -> NumberRule:
    return NumberRule(0.0, FARTHEST, "m", above=True)


def _value(highest: float) -> ElementRule:
    return ElementRule({"value": NumberRule(0.0, highest)})


_ORIGIN = ElementRule(
    {
        "xyz": NumberRule(-FARTHEST, FARTHEST, "m", 3, otherwise=""),
        "rpy": NumberRule(-4.0 * math.pi, 4.0 * math.pi, "rad", 3, otherwise=""),
    }
)
_MOMENT = NumberRule(0.0, 100.0, "kg m²")
_PRODUCT = NumberRule(-100.0, 100.0, "kg m²", otherwise="0")
_INERTIAL = ElementRule(
    children={
        "origin": _ORIGIN,
        "mass": ElementRule({"value": NumberRule(0.0, HEAVIEST, "kg")}),
        "inertia": ElementRule(
            {"ixx": _MOMENT, "iyy": _MOMENT, "izz": _MOMENT, "ixy": _PRODUCT, "ixz": _PRODUCT, "iyz": _PRODUCT}
        ),
    },
    needed=("mass", "inertia"),
)
_TUBE = ElementRule({"radius": _length(), "length": _length()})
_GEOMETRY = ElementRule(
    children={
        "box": ElementRule({"size": NumberRule(0.0, FARTHEST, "m", 3, above=True)}),
        "sphere": ElementRule({"radius": _length()}),
        "cylinder": _TUBE,
        "capsule": _TUBE,
        "mesh": ElementRule({"scale": NumberRule(-1e6, 1e6, "", 3, otherwise="")}, ("filename",)),
    },
    only_one=True,
)
_COLOUR = ElementRule({"rgba": NumberRule(0.0, 1.0, "", 4, otherwise="")}, drawn=True)
_MATERIAL = ElementRule(texts=("name",), children={"color": _COLOUR}, drawn=True)
ROBOT = ElementRule(children={"material": _MATERIAL}, many=("material",))
_COLLISION = ElementRule(children={"origin": _ORIGIN, "geometry": _GEOMETRY}, needed=("geometry",))
_VISUAL = ElementRule(children={**_COLLISION.children, "material": _MATERIAL}, needed=("geometry",), drawn=True)
_CONTACT = ElementRule(
    children={
        "lateral_friction": _value(10.0),
        "rolling_friction": _value(10.0),
        "spinning_friction": _value(10.0),
        "restitution": _value(1.0),
        "stiffness": _value(1e8),
        "damping": _value(1e6),
        "friction_anchor": ElementRule(),
    }
)
LINK = ElementRule(
    texts=("name",),
    children={"inertial": _INERTIAL, "visual": _VISUAL, "collision": _COLLISION, "contact": _CONTACT},
    many=("visual", "collision"),
)
_END = ElementRule(texts=("link",))
_ENDS = {"parent": _END, "child": _END, "origin": _ORIGIN}
_PLACE = NumberRule(-100.0, 100.0, "rad or m", otherwise="0")
_STRENGTH = NumberRule(0.0, 1e6, "", otherwise="0")
_FACTOR = NumberRule(-1e6, 1e6, "", otherwise="1")
_STRENGTHS = {"effort": _STRENGTH, "velocity": _STRENGTH}
_MOTION = {
    **_ENDS,
    "axis": ElementRule({"xyz": NumberRule(-1e6, 1e6, "", 3)}),
    "mimic": ElementRule({"multiplier": _FACTOR, "offset": _PLACE}, ("joint",)),
    "dynamics": ElementRule(
        {"damping": NumberRule(0.0, 1e4, "", otherwise=""), "friction": NumberRule(0.0, 1e4, "", otherwise="")}
    ),
}
_NAMED = ("name", "type")
_NEEDED = ("parent", "child")
FIXED_JOINT = ElementRule(texts=_NAMED, children=_ENDS, needed=_NEEDED)
MOVING_JOINT = ElementRule(
    texts=_NAMED,
    children={**_MOTION, "limit": ElementRule({"lower": _PLACE, "upper": _PLACE, **_STRENGTHS})},
    needed=_NEEDED,
)
CONTINUOUS_JOINT = ElementRule(
    texts=_NAMED, children={**_MOTION, "limit": ElementRule(_STRENGTHS)}, needed=_NEEDED
)  # URDF passes over limits of its place
