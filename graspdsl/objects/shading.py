"""Triangles with normals, for pictures: smooth where a surface is, sharp at its edges."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from graspdsl.arrays import Array

Faces = npt.NDArray[np.int64]
CREASE = float(np.radians(40.0))  # triangles that meet at a larger angle have an edge between them
MOST_DRAWN = 60_000  # triangles
DRAWN_CELLS = 80  # along the longest side
TINY = 1e-15


@dataclass(frozen=True, eq=False, slots=True)
class Shaded:
    """Triangles with the unit normals (v, 3) of the surface at their vertices (v, 3) [m]; faces (f, 3)."""

    vertices: Array
    normals: Array
    faces: Faces

    def placed(self, rotation: Array, position: Array) -> Shaded:
        """The triangles turned by a rotation (3, 3) about the origin, then moved by a position (3,) [m]."""
        return Shaded(self.vertices @ rotation.T + position, self.normals @ rotation.T, self.faces)


def shaded_mesh(vertices: Array, faces: Faces) -> Shaded:
    """A mesh with vertices (v, 3) [m] and faces (f, 3), coarser where it has very many, every corner on its own.

    The normal of a corner is the mean, by area, of the triangles about it that are joined without an edge between.
    """
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    vertices, faces = _coarsened(vertices, faces)
    corners, count = vertices[faces], 3 * len(faces)
    across = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    one, other = _neighbours(faces, across / np.linalg.norm(across, axis=1, keepdims=True))
    links = coo_array((np.ones(len(one)), (one, other)), shape=(count, count))
    groups, group = connected_components(links, directed=False)
    total = np.zeros((groups, 3))
    np.add.at(total, group, np.repeat(across, 3, axis=0))
    normals = total / np.maximum(np.linalg.norm(total, axis=1, keepdims=True), TINY)
    return Shaded(corners.reshape(-1, 3), normals[group], np.arange(count).reshape(-1, 3))


def _neighbours(faces: Faces, flat: Array) -> tuple[Faces, Faces]:
    """Pairs of corners (3 f + i) at the same vertex, of faces with normals (f, 3) that are joined smoothly there."""
    starts, ends = faces.reshape(-1), np.roll(faces, -1, axis=1).reshape(-1)
    corner = np.arange(len(starts))
    following = corner - corner % 3 + (corner + 1) % 3
    order = np.lexsort((np.maximum(starts, ends), np.minimum(starts, ends)))
    a, b = order[:-1], order[1:]
    # Edges of two triangles that face the same way run against each other.
    joined = (starts[a] == ends[b]) & (ends[a] == starts[b])
    a, b = a[joined], b[joined]
    smooth = (flat[a // 3] * flat[b // 3]).sum(axis=1) > np.cos(CREASE)
    a, b = a[smooth], b[smooth]
    return np.concatenate([a, following[a]]), np.concatenate([following[b], b])


def _coarsened(vertices: Array, faces: Faces) -> tuple[Array, Faces]:
    """Triangles that enclose area, vertices in the same cell of a grid being one where there are very many."""
    if len(faces) > MOST_DRAWN:
        grid = np.round(vertices / (np.ptp(vertices, axis=0).max() / DRAWN_CELLS)).astype(np.int64)
        _, kept, number = np.unique(grid, axis=0, return_index=True, return_inverse=True)
        vertices, faces = vertices[kept], number.reshape(-1)[faces]
    a, b, c = (vertices[faces[:, i]] for i in range(3))
    return vertices, faces[np.linalg.norm(np.cross(b - a, c - a), axis=1) > TINY]
