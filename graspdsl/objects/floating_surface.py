"""The surface of a shape, for contacts that float on it."""

from __future__ import annotations

from dataclasses import astuple

from graspdsl.objects import shapes, surfaces


def surface_of(shape: shapes.Shape) -> surfaces.Surface:
    """The closed smooth surface of a shape about the origin. Raises ValueError for a shape with sharp edges."""
    match shape:
        case shapes.Sphere(diameter):
            return surfaces.Sphere(diameter)
        case shapes.Ellipsoid((x, y, z)):
            return surfaces.Ellipsoid((x / 2, y / 2, z / 2))
        case shapes.Cylinder(diameter, height, edge):
            return surfaces.RoundedCylinder(diameter, height, edge)
        case shapes.Superquadric((x, y, z), exponent):
            return surfaces.Superquadric((x / 2, y / 2, z / 2), exponent)
        case shapes.Bottle():
            return surfaces.Bottle(*astuple(shape))
    raise ValueError(f"{type(shape).__name__.lower()} has sharp edges, on which a contact has no normal")
