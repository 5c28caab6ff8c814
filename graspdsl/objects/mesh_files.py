"""STL and OBJ files as solids. trimesh is loaded only where a spec names such a file."""

from __future__ import annotations

import io
import struct
from collections.abc import Callable
from pathlib import PurePath
from typing import TYPE_CHECKING, cast

import numpy as np

from graspdsl.arrays import Array
from graspdsl.diagnostics import Diagnostic, Severity
from graspdsl.objects.shading import Faces
from graspdsl.objects.surfaces.mesh import unit_sphere
from graspdsl.objects.triangles import TriangleMesh, enclosed
from graspdsl.places.files import refusal

if TYPE_CHECKING:
    from trimesh import Trimesh

MOST_FACES = 500_000
CLEARLY_HOLLOW = 1.05  # the volume of the hull over that of the mesh
FLAT = 1e-6  # the volume of the hull over the cube of its length
LONGEST, SHORTEST = 2.0, 0.005  # m, as for the shapes that a spec describes
MOST_LENGTH = 1e6  # m
HULL_DIRECTIONS = 32  # for each half turn; a hull with more corners than directions is thinned out
BINARY_HEADER, BINARY_FACE = 84, 50  # bytes

Warn = Callable[[Diagnostic], None]


def mesh_of_file(
    name: str, content: bytes, scale: Array, convex: str | None, warn: Warn, *, centred: bool = True
) -> TriangleMesh:
    """The solid in a file's content, scaled by (3,) along the axes, about the centre of its bounding box or, where that
    is not wanted, about the origin of the file.

    Raises DiagnosticError when there is none; what is only odd about it goes to ``warn``.
    """
    suffix = PurePath(name).suffix.lower()
    if suffix not in _READERS:
        message = f"{name} is no file of triangles that can be read: expected .stl or .obj"
        raise refusal("unknown-mesh-format", message, "convert it to STL or OBJ")
    if not content.strip():
        raise refusal("empty-mesh", f"{name} is empty", None)
    mesh = _READERS[suffix](name, content)
    if len(mesh.faces) == 0:
        raise refusal("empty-mesh", f"{name} holds no triangles", None)
    if len(mesh.faces) > MOST_FACES:
        raise _too_many(name, len(mesh.faces))
    corners = _corners(name, mesh)
    with np.errstate(over="ignore"):
        corners = corners * scale
        length = float(np.ptp(corners, axis=0).max())
    if length > MOST_LENGTH:
        raise refusal("bad-mesh", f"{name} is {length:.3g} m long", "check its scale")
    mesh.vertices = corners
    if np.prod(scale) < 0.0:
        mesh.invert()
    # Where textures or normals change across an edge, its corners are in the file once for each side.
    mesh.merge_vertices(merge_tex=True, merge_norm=True)
    mesh.update_faces(np.diff(np.sort(mesh.faces, axis=1), axis=1).all(axis=1))
    if len(mesh.faces) == 0:
        raise refusal("flat-mesh", f"{name} is flat: its triangles are lines", None)
    if centred:
        mesh.apply_translation(-mesh.bounds.mean(axis=0))
    return _solid(name, mesh, length, convex, warn)


def _corners(name: str, mesh: Trimesh) -> Array:
    """The corners (v, 3) of a mesh, which the library may have read as anything."""
    corners, faces = np.array(mesh.vertices), np.array(mesh.faces)
    if corners.shape[1:] != (3,):  # as many as its shortest line has
        what = f"has corners of {corners.shape[-1]} coordinates, where a solid has corners of three"
    elif not 0 <= faces.min() <= faces.max() < len(corners):
        what = "has triangles of corners that are not in it"
    elif not np.isfinite(corners).all():
        what = "has corners whose coordinates are no numbers"
    else:
        return corners
    raise refusal("bad-mesh", f"{name} {what}", "export it anew")


def _solid(name: str, mesh: Trimesh, length: float, convex: str | None, warn: Warn) -> TriangleMesh:
    hull = _convex_hull(np.array(mesh.vertices))
    if hull is None or enclosed(*hull).volume < FLAT * length**3:
        raise refusal("flat-mesh", f"{name} is flat: it encloses no volume", None)
    _warn_of_size(name, length, warn)
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


def _warn_of_size(name: str, length: float, warn: Warn) -> None:
    if SHORTEST <= length <= LONGEST:
        return
    message = f"{name} is {length:.3g} m long"
    hint = "if its file is in millimetres, write scale: 0.001" if length > LONGEST else "check its scale"
    warn(Diagnostic("object-size", message, None, hint, Severity.WARNING))


def _thinned(corners: Array) -> Array:
    """The corners (h, 3) of a hull, or of so many only those that reach farthest in evenly spread directions."""
    directions = unit_sphere(HULL_DIRECTIONS).reshape(-1, 3)
    if len(corners) <= len(directions):
        return corners
    chosen: Array = corners[np.unique([int(np.argmax(corners @ direction)) for direction in directions])]
    return chosen


def _too_many(name: str, faces: int) -> Exception:
    message = f"{name} has {faces} triangles, where an object may have {MOST_FACES}"
    return refusal("file-too-large", message, "simplify it")


def _stl(name: str, content: bytes) -> Trimesh:
    announced = struct.unpack("<I", content[80:84])[0] if len(content) >= BINARY_HEADER else 0
    held = (len(content) - BINARY_HEADER) // BINARY_FACE
    text = content.lstrip()[:5].lower() == b"solid" and announced != held
    if not text and announced > held:
        if announced > MOST_FACES or held < 0:
            raise refusal(
                "unreadable-mesh", f"{name} is no STL file, neither a binary one nor a text", "export it anew"
            )
        message = f"{name} is cut short: of the {announced} triangles that it announces it holds {held}"
        raise refusal("unreadable-mesh", message, "export it anew")
    faces = content.lower().count(b"endfacet") if text else announced
    if faces > MOST_FACES:
        raise _too_many(name, faces)
    return _parsed(name, io.BytesIO(content), "stl")


def _obj(name: str, content: bytes) -> Trimesh:
    lines = content.count(b"\nf ")
    if lines > MOST_FACES:
        raise _too_many(name, lines)
    try:
        return _parsed(name, io.StringIO(content.decode("utf-8")), "obj")
    except UnicodeDecodeError:
        raise refusal("unreadable-mesh", f"{name} is no OBJ file: it is not text", "export it anew") from None


def _parsed(name: str, stream: io.BytesIO | io.StringIO, kind: str) -> Trimesh:
    import trimesh

    try:
        # Materials would be read from yet other files.
        loaded = trimesh.load(stream, file_type=kind, skip_materials=True, process=False)
        meshes = loaded.dump() if isinstance(loaded, trimesh.Scene) else [loaded]
        parts = [mesh for mesh in meshes if isinstance(mesh, trimesh.Trimesh) and len(mesh.faces)]
        whole = trimesh.util.concatenate(parts) if parts else trimesh.Trimesh()
    except Exception as error:  # whatever a parser makes of a file that is none of its kind
        message = f"{name} cannot be read as {kind.upper()}: {error or type(error).__name__}"
        raise refusal("unreadable-mesh", message.splitlines()[0][:200], "export it anew") from None
    return cast("Trimesh", whole)


_READERS: dict[str, Callable[[str, bytes], Trimesh]] = {".stl": _stl, ".obj": _obj}
SUFFIXES = tuple(_READERS)
