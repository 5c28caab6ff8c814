"""What a hand's URDF may say: elements, how often each stands, and the bounds of every number in them.

What is not listed here is left out: nothing reaches the engine unchecked.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field

FIXED = "fixed"
HINGES = ("revolute", "prismatic", "continuous")
SHAPES = ("box", "sphere", "cylinder", "capsule", "mesh")
MESHES = (".stl", ".obj")
UNDRAWN = ".dae"  # the engine falls over files of this kind that lack something

FARTHEST = 10.0  # m
HEAVIEST = 100.0  # kg


@dataclass(frozen=True, slots=True)
class Numbers:
    """Numbers of an attribute, from ``lowest`` to ``highest``; ``above``: more than ``lowest``.

    ``otherwise`` stands for an attribute that is not there: None where it has to be, empty where it stays out.
    """

    lowest: float
    highest: float
    unit: str = ""
    count: int = 1
    above: bool = False
    otherwise: str | None = None


@dataclass(frozen=True, slots=True)
class Kind:
    """A kind of element: its numbers, attributes of text, what stands in it, what of that has to and may often."""

    numbers: Mapping[str, Numbers] = field(default_factory=dict)
    texts: tuple[str, ...] = ()
    children: Mapping[str, Kind] = field(default_factory=dict)
    needed: tuple[str, ...] = ()
    many: tuple[str, ...] = ()
    only_one: bool = False


def _length() -> Numbers:
    return Numbers(0.0, FARTHEST, "m", above=True)


def _value(highest: float) -> Kind:
    return Kind({"value": Numbers(0.0, highest)})


_ORIGIN = Kind(
    {
        "xyz": Numbers(-FARTHEST, FARTHEST, "m", 3, otherwise=""),
        "rpy": Numbers(-4.0 * math.pi, 4.0 * math.pi, "rad", 3, otherwise=""),
    }
)
_MOMENT = Numbers(0.0, 100.0, "kg m²")
_PRODUCT = Numbers(-100.0, 100.0, "kg m²", otherwise="0")
_INERTIAL = Kind(
    children={
        "origin": _ORIGIN,
        "mass": Kind({"value": Numbers(0.0, HEAVIEST, "kg")}),
        "inertia": Kind(
            {"ixx": _MOMENT, "iyy": _MOMENT, "izz": _MOMENT, "ixy": _PRODUCT, "ixz": _PRODUCT, "iyz": _PRODUCT}
        ),
    },
    needed=("mass", "inertia"),
)
_TUBE = Kind({"radius": _length(), "length": _length()})
_GEOMETRY = Kind(
    children={
        "box": Kind({"size": Numbers(0.0, FARTHEST, "m", 3, above=True)}),
        "sphere": Kind({"radius": _length()}),
        "cylinder": _TUBE,
        "capsule": _TUBE,
        "mesh": Kind({"scale": Numbers(-1e6, 1e6, "", 3, otherwise="")}, ("filename",)),
    },
    only_one=True,
)
MATERIAL = Kind(texts=("name",), children={"color": Kind({"rgba": Numbers(0.0, 1.0, "", 4, otherwise="")})})
_COLLISION = Kind(children={"origin": _ORIGIN, "geometry": _GEOMETRY}, needed=("geometry",))
_VISUAL = Kind(children={**_COLLISION.children, "material": MATERIAL}, needed=("geometry",))
_CONTACT = Kind(
    children={
        "lateral_friction": _value(10.0),
        "rolling_friction": _value(10.0),
        "spinning_friction": _value(10.0),
        "restitution": _value(1.0),
        "stiffness": _value(1e8),
        "damping": _value(1e6),
        "friction_anchor": Kind(),
    }
)
LINK = Kind(
    texts=("name",),
    children={"inertial": _INERTIAL, "visual": _VISUAL, "collision": _COLLISION, "contact": _CONTACT},
    many=("visual", "collision"),
)
_END = Kind(texts=("link",))
_ENDS = {"parent": _END, "child": _END, "origin": _ORIGIN}
_PLACE = Numbers(-100.0, 100.0, "rad or m", otherwise="0")
_STRENGTH = Numbers(0.0, 1e6, "", otherwise="0")
FIXED_JOINT = Kind(texts=("name", "type"), children=_ENDS, needed=("parent", "child"))
MOVING_JOINT = Kind(
    texts=("name", "type"),
    children={
        **_ENDS,
        "axis": Kind({"xyz": Numbers(-1e6, 1e6, "", 3)}),
        "limit": Kind({"lower": _PLACE, "upper": _PLACE, "effort": _STRENGTH, "velocity": _STRENGTH}),
        "dynamics": Kind(
            {"damping": Numbers(0.0, 1e4, "", otherwise=""), "friction": Numbers(0.0, 1e4, "", otherwise="")}
        ),
    },
    needed=("parent", "child"),
)
