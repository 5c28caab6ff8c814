"""Shapes as convex polyhedra, for an engine that knows no others, and as shaded triangles, for pictures."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from graspdsl.arrays import Array
from graspdsl.objects.shading import Shaded
from graspdsl.objects.surfaces.mesh import mesh_of_rings, unit_sphere
from graspdsl.objects.surfaces.profile import Profile
from graspdsl.objects.surfaces.surface import Surface

# Of 24, 32 and 48 facets a half turn, these gave the engine the best normals for its time: it takes points within 1 cm
# of each other for one when it looks for the nearest, so that more facets hardly help.
HALF_TURN = 32
AROUND = 96
FINEST = 0.002  # m between the levels of a rounded edge
ROUND_ENOUGH = 0.75  # the share of the largest margin that is taken
SLACK = 1e-6  # m


@dataclass(frozen=True, eq=False, slots=True)
class Hull:
    """All points within ``margin`` [m] of the convex hull of vertices (v, 3) [m].

    The margin rounds the facets: the larger it is, the truer are the normals of a contact.
    """

    vertices: Array
    margin: float = 0.0

    def placed(self, rotation: Array, position: Array) -> Hull:
        """The hull turned by a rotation (3, 3) about the origin, then moved by a position (3,) [m]."""
        return Hull(self.vertices @ rotation.T + position, self.margin)

    def support(self, direction: Array) -> float:
        """How far the hull reaches along a unit vector (3,) from the origin [m]."""
        return float((self.vertices @ direction).max()) + self.margin


def round_hull(size: tuple[float, float, float], exponent: float, surface: Surface | None = None) -> Hull:
    """The hull of |x/a|^p + |y/b|^p + |z/c|^p ≤ 1 of full size (2a, 2b, 2c) [m] and exponent p.

    Its vertices are where the surface has evenly spread normals and, where it is given, evenly far around it.
    """
    half, dual = np.array(size) / 2, exponent / (exponent - 1.0)
    normals = np.unique(np.round(unit_sphere(HALF_TURN).reshape(-1, 3), 12), axis=0)
    reach = np.linalg.norm(normals * half, ord=dual, axis=1, keepdims=True)
    vertices = np.copysign(half * (np.abs(normals) * half / reach) ** (dual - 1.0), normals)
    margin = ROUND_ENOUGH * _largest_margin(vertices, normals)
    if surface is not None and exponent > 2.0:
        more = surface.rings(HALF_TURN).reshape(-1, 3)
        vertices, normals = np.concatenate([vertices, more]), np.concatenate([normals, surface.normals(more)])
    return Hull(vertices - margin * normals, margin)


def _largest_margin(vertices: Array, normals: Array) -> float:
    """By how much [m] a convex surface can be moved inwards along its normals until it is no longer convex.

    With support function h(n) that is the largest m for which every v_j − m n_j stays within the planes
    n_i · x ≤ h(n_i) − m.
    """
    reach = normals @ vertices.T
    inside = np.diag(reach)[:, None] - reach + SLACK
    apart = 1.0 - normals @ normals.T
    return float((inside[apart > SLACK] / apart[apart > SLACK]).min())


def _section(width: float, exponent: float) -> tuple[Array, Array]:
    """Points (s, 2) around |x|^n + |y/w|^n = 1, and normals: half of them at even normals, half at even angles."""
    half, dual = np.array([1.0, width]), exponent / (exponent - 1.0)
    angles = 2.0 * np.pi * np.arange(AROUND // 2) / (AROUND // 2)
    unit = np.stack([np.cos(angles), np.sin(angles)], axis=-1)
    reach = np.linalg.norm(unit * half, ord=dual, axis=1, keepdims=True)
    even_normals = np.copysign(half * (np.abs(unit) * half / reach) ** (dual - 1.0), unit)
    between = np.stack([np.cos(angles + angles[1] / 2), np.sin(angles + angles[1] / 2)], axis=-1)
    even_angles = between * half / np.linalg.norm(between, ord=exponent, axis=1, keepdims=True)
    points = np.concatenate([even_normals, even_angles])
    points = points[np.argsort(np.arctan2(points[:, 1] / width, points[:, 0]))]
    normals = np.copysign((np.abs(points) / half) ** (exponent - 1.0) / half, points)
    return points, normals / np.linalg.norm(normals, axis=1, keepdims=True)


def _rings(outline: Array, section: Array) -> Array:
    """Rings (r, s, 3) of a section (s, 2), scaled by the first column of an outline (r, 2), at the second's heights."""
    heights = np.broadcast_to(outline[:, None, 1:], (len(outline), len(section), 1))
    return np.concatenate([outline[:, None, :1] * section, heights], axis=-1)


def _stacked_normals(profile: Profile, outline: Array, section: Array, normals: Array) -> Array:
    """The normals at the vertices of mesh_of_rings(_rings(outline, section)), (v, 3).

    A section N · x = ρ h with normal N and support h gives (n_ρ N, n_z h) for the outline's normal (n_ρ, n_z).
    """
    _, along = profile.nearest(outline)
    reach = (section * normals).sum(axis=1)
    level = along[:, None, :1] * normals
    upward = along[:, None, 1:] * reach[:, None]
    whole = np.concatenate([level, upward], axis=-1)
    whole /= np.linalg.norm(whole, axis=-1, keepdims=True)
    poles = np.array([[0.0, 0.0, -1.0]]), np.array([[0.0, 0.0, 1.0]])
    return np.concatenate([poles[0], whole[1:-1].reshape(-1, 3), poles[1]])


def stacked_hulls(outline: Array, width: float = 1.0, exponent: float = 2.0) -> tuple[Hull, ...]:
    """Slices of stacked sections |x/ρ|^n + |y/(wρ)|^n ≤ 1, cut level wherever the outline (r, 2) turns outwards."""
    section, _ = _section(width, exponent)
    rings = _rings(outline, section)
    steps = np.diff(outline, axis=0)
    turns = steps[:-1, 0] * steps[1:, 1] - steps[:-1, 1] * steps[1:, 0]
    straight = 1e-9 * np.hypot(*steps[:-1].T) * np.hypot(*steps[1:].T)
    cuts = [0, *(np.flatnonzero(turns < -straight) + 1).tolist(), len(outline) - 1]
    slices = (rings[low : high + 1].reshape(-1, 3) for low, high in pairwise(cuts))
    return tuple(Hull(np.unique(np.round(vertices, 9), axis=0)) for vertices in slices)


def stacked_facets(profile: Profile, width: float, exponent: float) -> Shaded:
    """The surface of stacked sections |x/ρ|^n + |y/(wρ)|^n ≤ 1 of an outline ρ(z)."""
    outline = profile.outline(HALF_TURN, FINEST)
    section, normals = _section(width, exponent)
    mesh = mesh_of_rings(_rings(outline, section))
    return Shaded(mesh.vertices, _stacked_normals(profile, outline, section, normals), mesh.faces)
