"""Objects to grasp: one solid shape with a mass, standing on the table as its z axis does."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

import yaml

from graspdsl.objects.compound import Compound, Loft, Placed, standing
from graspdsl.objects.primitives import Bottle, Box, Cylinder, Ellipsoid, Extent, Sphere, Superquadric
from graspdsl.objects.triangles import TriangleMesh

__all__ = [
    "SHAPES",
    "Body",
    "Bottle",
    "Box",
    "Compound",
    "Cylinder",
    "Ellipsoid",
    "Shape",
    "Sphere",
    "Superquadric",
    "TriangleMesh",
    "catalogue",
    "shape_from",
]

Shape = Cylinder | Sphere | Box | Ellipsoid | Superquadric | Bottle | Compound | TriangleMesh
CLEARLY_LONGER = 1.05
UPRIGHT = (0.0, 0.0, 1.0)


@dataclass(frozen=True, slots=True)
class Body:
    """A rigid object: a shape of even density and a mass [kg]; ``digest``: a hash of the files it was read from."""

    name: str
    shape: Shape
    mass: float
    about: str = ""
    digest: str = ""

    @property
    def major_axis(self) -> Extent:
        """The unit vector, in the body's frame, against which orientations are reported: z, or the axis of the longest
        extent of a box, an ellipsoid, a superquadric or a shape from a file where that is clearly the longest."""
        shape = self.shape
        measured = isinstance(shape, Box | Ellipsoid | Superquadric | TriangleMesh)
        if not (measured or (isinstance(shape, Compound) and shape.from_elsewhere)):
            return UPRIGHT
        extent = self.shape.extent
        _, second, longest = sorted(extent)
        if longest <= CLEARLY_LONGER * second:
            return UPRIGHT
        x, y, z = (float(size == longest) for size in extent)
        return (x, y, z)


def shape_from(form: Mapping[str, Any]) -> Shape:
    """The shape in a mapping with one of the keys of SHAPES, its fields beneath it."""
    kind = next(kind for kind in SHAPES if form.get(kind) is not None)
    fields = form[kind]
    return SHAPES[kind](**fields) if isinstance(fields, Mapping) else SHAPES[kind](fields)


def _size(size: Sequence[float]) -> Extent:
    x, y, z = size
    return float(x), float(y), float(z)


def _placed(form: Mapping[str, Any]) -> Placed:
    part: Loft | Box
    if "loft" in form:
        fields = {**form["loft"], "roundings": tuple(form["loft"]["roundings"])}
        part = Loft(**{**fields, "corners": tuple((rho, z) for rho, z in fields["corners"])})
    else:
        part = Box(_size(form["box"]["size"]))
    return Placed(part, _size(form.get("at", (0.0, 0.0, 0.0))), (0.0, form.get("pitch", 0.0), 0.0))


SHAPES: Mapping[str, Callable[..., Shape]] = {
    "cylinder": Cylinder,
    "sphere": Sphere,
    "box": lambda size: Box(_size(size)),
    "ellipsoid": lambda size: Ellipsoid(_size(size)),
    "superquadric": lambda size, exponent: Superquadric(_size(size), exponent),
    "bottle": Bottle,
    "compound": lambda parts: standing([_placed(part) for part in parts]),
}


@cache
def catalogue() -> Mapping[str, Body]:
    """The objects that a spec can name."""
    entries = yaml.safe_load(Path(__file__).with_name("catalogue.yaml").read_text("utf-8"))
    return {
        name: Body(name, shape_from(entry), float(entry["mass"]), entry.get("about", ""))
        for name, entry in entries.items()
    }
