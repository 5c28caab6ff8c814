"""Files of triangles as solids. trimesh is loaded only where a spec names such a file."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np

from graspdsl.arrays import Array
from graspdsl.diagnostics import Diagnostic, Severity
from graspdsl.models.mesh_files import triangles
from graspdsl.objects.shading import Faces
from graspdsl.objects.shape import LONGEST, SHORTEST
from graspdsl.objects.surfaces.mesh import unit_sphere
from graspdsl.objects.triangles import TriangleMesh, enclosed
from graspdsl.places.files import refusal

if TYPE_CHECKING:
    from trimesh import Trimesh

CLEARLY_HOLLOW = 1.05  # the volume of the hull over that of the mesh
FLAT = 1e-6  # the volume of the hull over the cube of its length
SPECK = 1e-4  # m
MOST_LENGTH = 1e6  # m
HULL_DIRECTIONS = 32  # for each half turn; a hull with more corners than directions is thinned out

Warn = Callable[[Diagnostic], None]


def mesh_of_file(name: str, content: bytes, scale: float, convex: str | None, warn: Warn) -> TriangleMesh:
    """The solid in a file's content, scaled, about the centre of its bounding box.

    Raises DiagnosticError when there is none; what is only odd about it goes to ``warn``.
    """
    corners, faces = triangles(name, content)
    with np.errstate(over="ignore"):
        corners = corners * scale
    solid = mesh_of_triangles(name, corners, faces, convex, warn)
    return solid.moved(-(solid.vertices.min(axis=0) + solid.vertices.max(axis=0)) / 2)


def mesh_of_triangles(name: str, corners: Array, faces: Faces, convex: str | None, warn: Warn) -> TriangleMesh:
    """The solid that triangles of corners (v, 3) [m] enclose, which is called by a name in what is said of it.

    Raises DiagnosticError when they enclose none; what is only odd about it goes to ``warn``.
    """
    from trimesh import Trimesh

    with np.errstate(over="ignore"):
        length = float(np.ptp(corners, axis=0).max())
    if not length <= MOST_LENGTH:
        raise refusal("bad-mesh", f"{name} is {length:.3g} m long", "check its scale")
    mesh = Trimesh(corners, faces, process=False)
    # Where textures or normals change across an edge, its corners are in the file once for each side.
    mesh.merge_vertices(merge_tex=True, merge_norm=True)
    mesh.update_faces(np.diff(np.sort(mesh.faces, axis=1), axis=1).all(axis=1))
    if len(mesh.faces) == 0:
        raise refusal("flat-mesh", f"{name} is flat: its triangles are lines", None)
    return _solid(name, mesh, length, convex, warn)


def _solid(name: str, mesh: Trimesh, length: float, convex: str | None, warn: Warn) -> TriangleMesh:
    hull = _convex_hull(np.array(mesh.vertices))
    if hull is None or enclosed(*hull).volume < FLAT * length**3:
        raise refusal("flat-mesh", f"{name} is flat: it encloses no volume", None)
    warn_of_size(name, length, warn)
    closed = bool(mesh.is_watertight and mesh.is_winding_consistent)
    if closed and mesh.volume < 0.0:
        mesh.invert()
    if closed and mesh.volume < FLAT * length**3:
        raise refusal("flat-mesh", f"{name} encloses no volume", None)
    if not closed:
        what = "has triangles that face both ways" if mesh.is_watertight else "has holes"
        message = f"{name} {what}: it is not watertight, so the mass of its convex hull is used"
        warn(
            Diagnostic(
                "mesh-not-watertight", message, None, "close it, for mass and inertia as they are", Severity.WARNING
            )
        )
    vertices, faces, filled = np.array(mesh.vertices), np.array(mesh.faces, dtype=np.int64), enclosed(*hull)
    solid = enclosed(vertices, faces) if closed else filled
    return TriangleMesh(
        vertices=vertices,
        faces=faces,
        hull=_thinned(hull[0]),
        content=solid,
        convex_parts=convex or ("decomposition" if filled.volume > CLEARLY_HOLLOW * solid.volume else "hull"),
    )


def _convex_hull(vertices: Array) -> tuple[Array, Faces] | None:
    """The corners (h, 3) of the convex hull and its triangles (f, 3), seen from outside; None of flat points."""
    from scipy.spatial import ConvexHull, QhullError

    try:
        hull = ConvexHull(vertices)
    except QhullError:
        return None
    chosen, number = np.unique(hull.simplices, return_inverse=True)
    corners, faces = vertices[chosen], number.reshape(hull.simplices.shape).astype(np.int64)
    a, b, c = (corners[faces[:, i]] for i in range(3))
    inward = (np.cross(b - a, c - a) * hull.equations[:, :3]).sum(axis=1) < 0.0
    faces[inward] = faces[inward][:, ::-1]
    return corners, faces


def warn_of_size(name: str, length: float, warn: Warn, hint: str | None = None) -> None:
    """Say where a length [m] is none of an object that a hand grasps; by default the scale is a hint.

    Raises DiagnosticError for what is so small that no engine can have it.
    """
    if SHORTEST <= length <= LONGEST:
        return
    message = f"{name} is {length:.3g} m long"
    scale = "if its file is in millimetres, write scale: 0.001" if length > LONGEST else "check its scale"
    if length < SPECK:
        raise refusal("object-size", message, hint or scale)
    warn(Diagnostic("object-size", message, None, hint or scale, Severity.WARNING))


def _thinned(corners: Array) -> Array:
    """The corners (h, 3) of a hull, or of so many only those that reach farthest in evenly spread directions."""
    directions = unit_sphere(HULL_DIRECTIONS).reshape(-1, 3)
    if len(corners) <= len(directions):
        return corners
    chosen: Array = corners[np.unique([int(np.argmax(corners @ direction)) for direction in directions])]
    return chosen
