"""The shapes that a spec can describe, and objects: one shape with a mass, standing on the table as its z axis does."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

from pydantic import VERSION

from graspdsl.objects.bottle import Bottle
from graspdsl.objects.box import Box
from graspdsl.objects.compound import Loft, Placed, standing
from graspdsl.objects.cylinder import Cylinder
from graspdsl.objects.ellipsoid import Ellipsoid
from graspdsl.objects.shape import DescribedShape, Extent, Shape
from graspdsl.objects.sphere import Sphere
from graspdsl.objects.superquadric import Superquadric
from graspdsl.places.data_files import data_in
from graspdsl.places.kept import kept

SHAPES: dict[str, type[DescribedShape]] = {
    "cylinder": Cylinder,
    "sphere": Sphere,
    "box": Box,
    "ellipsoid": Ellipsoid,
    "superquadric": Superquadric,
    "bottle": Bottle,
}


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
        """The unit vector, in the body's frame, against which orientations are reported."""
        return self.shape.major_axis


def shape_from(form: Mapping[str, Any]) -> Shape:
    """The shape in an entry of the catalogue: its fields beneath one of the keys of SHAPES, or a compound's parts."""
    if "compound" in form:
        return standing([_placed(part) for part in form["compound"]])
    name = next(name for name in SHAPES if name in form)
    return SHAPES[name].model_validate(form[name])


def _placed(form: Mapping[str, Any]) -> Placed:
    part: Shape
    if "loft" in form:
        fields = {**form["loft"], "roundings": tuple(form["loft"]["roundings"])}
        part = Loft(**{**fields, "corners": tuple((rho, z) for rho, z in fields["corners"])})
    else:
        part = shape_from(form)
    return Placed(part, _size(form.get("at", (0.0, 0.0, 0.0))), (0.0, form.get("pitch", 0.0), 0.0))


def _size(size: Sequence[float]) -> Extent:
    x, y, z = size
    return float(x), float(y), float(z)


@cache
def catalogue() -> dict[str, Body]:
    """The objects that a spec can name; those of ``objects_in`` can be added to it."""
    return kept("objects", VERSION, _described)


def _described() -> dict[str, Body]:
    entries = data_in(Path(__file__).with_name("catalogue.yaml"))
    return {
        name: Body(name, shape_from(entry), float(entry["mass"]), entry.get("about", ""))
        for name, entry in entries.items()
    }
