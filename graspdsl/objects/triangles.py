"""Solids bounded by triangles: a user's own meshes."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from graspdsl.arrays import Array
from graspdsl.objects.mass import Solid
from graspdsl.objects.primitives import Extent

Faces = npt.NDArray[np.int64]


@dataclass(frozen=True, eq=False, slots=True)
class TriangleMesh:
    """A solid with vertices (v, 3) [m] and faces (f, 3); alone, its origin is the centre of its bounding box.

    ``hull`` (h, 3) [m] are the corners of its convex hull. It collides as that hull, or where ``convex_parts`` is
    "decomposition" as convex parts that fill it more closely.
    """

    vertices: Array
    faces: Faces
    hull: Array
    solid: Solid
    convex_parts: str = "hull"

    @property
    def extent(self) -> Extent:
        """Full size along x, y, z [m]."""
        x, y, z = np.ptp(self.vertices, axis=0).tolist()
        return (x, y, z)

    def support(self, direction: Array) -> float:
        """How far the shape reaches from its origin along a unit vector (3,) [m]."""
        return float((self.hull @ direction).max())


def enclosed(vertices: Array, faces: Faces) -> Solid:
    """The solid within closed triangles, counter-clockwise seen from outside.

    Each triangle (a, b, c) makes a tetrahedron with the origin, of signed volume V = a · (b × c) / 6, centre
    s / 4 with s = a + b + c, and ∫ r rᵀ dV = V (a aᵀ + b bᵀ + c cᵀ + s sᵀ) / 20.
    """
    origin = vertices.mean(axis=0)
    corners = vertices[faces] - origin
    volumes = np.einsum("fi,fi->f", corners[:, 0], np.cross(corners[:, 1], corners[:, 2])) / 6
    sums = corners.sum(axis=1)
    volume = float(volumes.sum())
    centre = (volumes @ sums) / (4 * volume)
    second = np.einsum("f,fki,fkj->ij", volumes, corners, corners) + np.einsum("f,fi,fj->ij", volumes, sums, sums)
    return Solid(volume, centre + origin, second / 20 - volume * np.outer(centre, centre))
