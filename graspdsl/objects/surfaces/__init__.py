"""Closed smooth surfaces for contacts that float on an object: level, normals, retraction, even samples."""

from graspdsl.objects.surfaces.bottle import Bottle
from graspdsl.objects.surfaces.ellipsoid import Ellipsoid
from graspdsl.objects.surfaces.mesh import Mesh
from graspdsl.objects.surfaces.revolution import Revolution
from graspdsl.objects.surfaces.rounded_cylinder import RoundedCylinder
from graspdsl.objects.surfaces.sphere import Sphere
from graspdsl.objects.surfaces.superquadric import Superquadric
from graspdsl.objects.surfaces.surface import Surface

__all__ = [
    "Bottle",
    "Ellipsoid",
    "Mesh",
    "Revolution",
    "RoundedCylinder",
    "Sphere",
    "Superquadric",
    "Surface",
]
