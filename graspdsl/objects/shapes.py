"""Objects to grasp: one solid shape with a mass; its major axis is the body's z axis."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

import yaml


@dataclass(frozen=True, slots=True)
class Cylinder:
    """A cylinder along z, diameter and height [m]; ``edge`` [m] rounds its edges where contacts float."""

    diameter: float
    height: float
    edge: float = 0.005

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


@dataclass(frozen=True, slots=True)
class Ellipsoid:
    """An ellipsoid, full size along x, y, z [m]."""

    size: tuple[float, float, float]

    @property
    def extent(self) -> tuple[float, float, float]:
        """Full size along x, y, z [m]."""
        return self.size


@dataclass(frozen=True, slots=True)
class Superquadric:
    """|x/a|^p + |y/b|^p + |z/c|^p = 1: full size (2a, 2b, 2c) [m], exponent p from a ball (2) to a box (10)."""

    size: tuple[float, float, float]
    exponent: float

    @property
    def extent(self) -> tuple[float, float, float]:
        """Full size along x, y, z [m]."""
        return self.size


@dataclass(frozen=True, slots=True)
class Bottle:
    """A bottle of revolution along z: body, shoulder and neck [m]; ``shoulder`` and ``edge`` are roundings."""

    diameter: float
    height: float
    neck_diameter: float
    body_height: float
    neck_height: float
    shoulder: float
    edge: float

    @property
    def extent(self) -> tuple[float, float, float]:
        """Full size along x, y, z [m]."""
        return (self.diameter, self.diameter, self.height)


Shape = Cylinder | Sphere | Box | Ellipsoid | Superquadric | Bottle


@dataclass(frozen=True, slots=True)
class Body:
    """A rigid object: a shape of even density and a mass [kg]."""

    name: str
    shape: Shape
    mass: float
    about: str = ""


def shape_from(form: Mapping[str, Any]) -> Shape:
    """The shape in a mapping with one of the keys of SHAPES, its fields beneath it."""
    kind = next(kind for kind in SHAPES if form.get(kind) is not None)
    return SHAPES[kind](**form[kind])


def _size(size: Sequence[float]) -> tuple[float, float, float]:
    x, y, z = size
    return float(x), float(y), float(z)


SHAPES: Mapping[str, Callable[..., Shape]] = {
    "cylinder": Cylinder,
    "sphere": Sphere,
    "box": lambda size: Box(_size(size)),
    "ellipsoid": lambda size: Ellipsoid(_size(size)),
    "superquadric": lambda size, exponent: Superquadric(_size(size), exponent),
    "bottle": Bottle,
}


@cache
def catalogue() -> Mapping[str, Body]:
    """The objects that a spec can name."""
    entries = yaml.safe_load(Path(__file__).with_name("catalogue.yaml").read_text("utf-8"))
    return {
        name: Body(name, shape_from(entry), float(entry["mass"]), entry.get("about", ""))
        for name, entry in entries.items()
    }
