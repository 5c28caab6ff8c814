"""Solids bounded by triangles: a user's own meshes, and as convex parts where they are hollow."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cache
from typing import ClassVar

import numpy as np

from graspdsl.arrays import Array, Flags
from graspdsl.objects.facets import Hull
from graspdsl.objects.mass import Solid
from graspdsl.objects.shading import Faces, Shaded, shaded_mesh
from graspdsl.objects.shape import Extent, Shape

# A ring of 10 cm took 27 s by the engine's own settings and 3 s by these, its size right within half a millimetre.
SETTINGS = {"maxConvexHulls": 32, "resolution": 20_000, "maxNumVerticesPerCH": 64}
ROUNDING = 1e-9  # of a volume
AT_ONCE = 4096  # triangles, so that even large ones do not fill the memory
ASIDE = 1e-7 * np.array([np.sqrt(2.0), np.sqrt(3.0)])  # of the size of a mesh: lines of points keep off its edges


@dataclass(frozen=True, eq=False)
class TriangleMesh(Shape):
    """A solid with vertices (v, 3) [m] and faces (f, 3); alone, its origin is the centre of its bounding box.

    ``hull`` (h, 3) [m] are the corners of its convex hull. It collides as that hull, or where ``convex_parts`` is
    "decomposition" as convex parts that fill it more closely.
    """

    name: ClassVar = "mesh"
    edged: ClassVar = True
    convex: ClassVar = False
    upright: ClassVar = False

    vertices: Array
    faces: Faces
    hull: Array
    content: Solid
    convex_parts: str = "hull"

    def moved(self, by: Array) -> TriangleMesh:
        """The solid moved by (3,) [m]."""
        solid = self.content.placed(np.eye(3), by)
        return replace(self, vertices=self.vertices + by, hull=self.hull + by, content=solid)

    @property
    def extent(self) -> Extent:
        """Full size along x, y, z [m]."""
        x, y, z = np.ptp(self.vertices, axis=0).tolist()
        return (x, y, z)

    def support(self, direction: Array) -> float:
        """How far the shape reaches from its origin along a unit vector (3,) [m]."""
        return float((self.hull @ direction).max())

    @property
    def solid(self) -> Solid:
        """What its mass is counted for."""
        return self.content

    def facets(self) -> tuple[Shaded, ...]:
        """Its triangles."""
        return (shaded_mesh(self.vertices, self.faces),)

    def hulls(self) -> tuple[Hull, ...]:
        """Its convex hull, or convex parts that nearly fill it."""
        return (Hull(self.hull),) if self.convex_parts == "hull" else tuple(map(Hull, _decomposed(self)))

    def inside(self) -> Callable[[Array], Flags]:
        """What its mass is counted for: all in its convex hull where it has holes, else within its triangles."""
        triangles = self.vertices[self.faces]
        volume = np.linalg.det(triangles - self.vertices.mean(axis=0)).sum() / 6.0
        if abs(volume - self.solid.volume) > ROUNDING * self.solid.volume:
            from scipy.spatial import ConvexHull

            triangles = self.vertices[ConvexHull(self.vertices).simplices]
        return lambda lines: _between_triangles(triangles, lines)


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


@cache
def _decomposed(shape: TriangleMesh) -> tuple[Array, ...]:
    """The corners (v, 3) of convex polyhedra that nearly fill a mesh, by V-HACD; the same for the same mesh."""
    # Loaded only for a mesh to decompose.
    from trimesh import Trimesh
    from trimesh.decomposition import convex_decomposition

    mesh = Trimesh(shape.vertices, shape.faces, process=False)
    return tuple(np.array(part["vertices"]) for part in convex_decomposition(mesh, **SETTINGS))


def _between_triangles(triangles: Array, lines: Array) -> Flags:
    """Which points of parallel lines (l, k, 3) are within closed triangles (f, 3, 3): an odd number lies ahead."""
    _, _, basis = np.linalg.svd((lines[0, -1] - lines[0, 0])[None])
    turned = np.roll(basis, -1, axis=0).T  # the direction of the lines comes last
    triangles, lines = triangles @ turned, lines @ turned
    starts = lines[:, 0, :2] + ASIDE * np.ptp(triangles, axis=(0, 1)).max()
    order = np.argsort(starts[:, 0])
    ahead = np.zeros(lines.shape[:2], dtype=np.int64)
    for begin in range(0, len(triangles), AT_ONCE):
        some = triangles[begin : begin + AT_ONCE]
        low, high = some[..., :2].min(axis=1), some[..., :2].max(axis=1)
        first, last = (np.searchsorted(starts[order, 0], side) for side in (low[:, 0], high[:, 0]))
        face = np.repeat(np.arange(len(some)), last - first)
        line = order[np.arange(len(face)) - np.repeat(np.cumsum(last - first) - last, last - first)]
        near = (low[face, 1] < starts[line, 1]) & (starts[line, 1] < high[face, 1])
        _count(some[face[near]], line[near], starts, lines[..., 2], ahead)
    return np.asarray(ahead % 2 == 1)


def _count(triangles: Array, line: Faces, starts: Array, heights: Array, ahead: Faces) -> None:
    """Add to ``ahead`` (l, k) the triangles (n, 3, 3), each with a line that may hit it, above the points there."""
    a, b, c = np.moveaxis(triangles - np.insert(starts[line], 2, 0.0, axis=1)[:, None], 1, 0)
    shares = np.stack([_area(b, c), _area(c, a), _area(a, b)], axis=-1)
    hit = (shares > 0.0).all(axis=1) | (shares < 0.0).all(axis=1)
    crossings = (shares * triangles[..., 2])[hit].sum(axis=1) / shares[hit].sum(axis=1)
    np.add.at(ahead, line[hit], crossings[:, None] > heights[line[hit]])


def _area(p: Array, q: Array) -> Array:
    """Twice the signed areas (n,) of triangles of the origin, p and q (n, 2 or more), seen along z."""
    area: Array = p[:, 0] * q[:, 1] - p[:, 1] * q[:, 0]
    return area
