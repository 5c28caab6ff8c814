"""Objects to grasp: one solid shape with a mass; its major axis is the body's z axis."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

import yaml


@dataclass(frozen=True, slots=True)
class Cylinder:
    """A cylinder along z, diameter and height [m]."""

    diameter: float
    height: float

    @property
    def extent(self) -> tuple[float, float, float]:
        """Full size along x, y, z [m]."""
        return (self.diameter, self.diameter, self.height)


@dataclass(frozen=True, slots=True)
class Sphere:
    """A sphere, diameter [m]."""

    diameter: float

    @property
    def extent(self) -> tuple[float, float, float]:
        """Full size along x, y, z [m]."""
        return (self.diameter,) * 3


@dataclass(frozen=True, slots=True)
class Box:
    """A box, full size along x, y, z [m]."""

    size: tuple[float, float, float]

    @property
    def extent(self) -> tuple[float, float, float]:
        """Full size along x, y, z [m]."""
        return self.size


Shape = Cylinder | Sphere | Box


@dataclass(frozen=True, slots=True)
class Body:
    """A rigid object: a shape of even density and a mass [kg]."""

    name: str
    shape: Shape
    mass: float
    about: str = ""


def shape_from(form: Mapping[str, Any]) -> Shape:
    """The shape in a mapping with one of the keys ``cylinder``, ``sphere``, ``box``, its fields beneath it."""
    if cylinder := form.get("cylinder"):
        return Cylinder(float(cylinder["diameter"]), float(cylinder["height"]))
    if sphere := form.get("sphere"):
        return Sphere(float(sphere["diameter"]))
    x, y, z = form["box"]["size"]
    return Box((float(x), float(y), float(z)))


@cache
def catalogue() -> Mapping[str, Body]:
    """The objects that a spec can name."""
    entries = yaml.safe_load(Path(__file__).with_name("catalogue.yaml").read_text("utf-8"))
    return {
        name: Body(name, shape_from(entry), float(entry["mass"]), entry.get("about", ""))
        for name, entry in entries.items()
    }
