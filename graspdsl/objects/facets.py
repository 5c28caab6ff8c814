"""Shapes as convex polyhedra, for an engine that knows no others, and as shaded triangles, for pictures."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache, singledispatch
from itertools import pairwise

import numpy as np

from graspdsl.arrays import Array
from graspdsl.objects import surfaces
from graspdsl.objects.compound import Compound, Loft, Part
from graspdsl.objects.floating_surface import surface_of
from graspdsl.objects.shading import Shaded, shaded_mesh
from graspdsl.objects.shapes import Bottle, Box, Cylinder, Ellipsoid, Shape, Sphere, Superquadric, TriangleMesh
from graspdsl.objects.surfaces.mesh import mesh_of_rings, unit_sphere
from graspdsl.objects.surfaces.profile import Profile

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


@cache
def convex_parts(shape: Shape) -> tuple[Hull, ...]:
    """Convex polyhedra that together fill a shape, in its own frame."""
    return _parts(shape)


@cache
def shaded(shape: Shape) -> tuple[Shaded, ...]:
    """The surface of a shape for drawing, in its own frame."""
    return _surface(shape)


@singledispatch
def _parts(shape: object) -> tuple[Hull, ...]:
    raise TypeError(f"{type(shape).__name__} is no shape")


@_parts.register
def _(shape: Box) -> tuple[Hull, ...]:
    signs = np.stack(np.meshgrid(*[(-0.5, 0.5)] * 3), axis=-1).reshape(-1, 3)
    return (Hull(signs * np.array(shape.size)),)


@_parts.register
def _(shape: Sphere) -> tuple[Hull, ...]:
    return _smooth(shape, 2.0)


@_parts.register
def _(shape: Cylinder) -> tuple[Hull, ...]:
    radius, top = shape.diameter / 2, shape.height / 2
    return _stack(np.array([(0.0, -top), (radius, -top), (radius, top), (0.0, top)]), 1.0, 2.0)


@_parts.register
def _(shape: Ellipsoid) -> tuple[Hull, ...]:
    return _smooth(shape, 2.0)


@_parts.register
def _(shape: Superquadric) -> tuple[Hull, ...]:
    return _smooth(shape, shape.exponent)


@_parts.register
def _(shape: Bottle) -> tuple[Hull, ...]:
    return _stack(shape.profile.outline(HALF_TURN, FINEST), 1.0, 2.0)


@_parts.register
def _(shape: Loft) -> tuple[Hull, ...]:
    return _stack(shape.profile.outline(HALF_TURN, FINEST), shape.width, shape.exponent)


@_parts.register
def _(shape: Compound) -> tuple[Hull, ...]:
    placed = ((p, hull) for p in shape.parts for hull in _sharp(p.part))
    return tuple(hull.placed(p.rotation, np.array(p.at)) for p, hull in placed)


@_parts.register
def _(shape: TriangleMesh) -> tuple[Hull, ...]:
    if shape.convex_parts == "hull":
        return (Hull(shape.hull),)
    # Loaded only for a mesh to decompose.
    from graspdsl.objects.decomposition import decomposed

    return tuple(Hull(vertices) for vertices in decomposed(shape))


def _sharp(part: Part) -> tuple[Hull, ...]:
    """Hulls without margins, since the parts of a compound have one in common."""
    return (Hull(_surface(part)[0].vertices),) if isinstance(part, Sphere) else _parts(part)


@singledispatch
def _surface(shape: object) -> tuple[Shaded, ...]:
    raise TypeError(f"{type(shape).__name__} is no shape")


@_surface.register(Ellipsoid)
@_surface.register(Superquadric)
@_surface.register(Sphere)
@_surface.register(Bottle)
def _(shape: Ellipsoid | Superquadric | Sphere | Bottle) -> tuple[Shaded, ...]:
    surface = surface_of(shape)
    mesh = surface.mesh(HALF_TURN)
    return (Shaded(mesh.vertices, surface.normals(mesh.vertices), mesh.faces),)


@_surface.register
def _(shape: Cylinder) -> tuple[Shaded, ...]:
    edge = min(shape.edge, shape.diameter / 4, shape.height / 4)
    surface = surfaces.RoundedCylinder(shape.diameter, shape.height, edge)
    mesh = surface.mesh(HALF_TURN)
    return (Shaded(mesh.vertices, surface.normals(mesh.vertices), mesh.faces),)


@_surface.register
def _(shape: Box) -> tuple[Shaded, ...]:
    square = np.array([(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)])
    sides = []
    for axis in range(3):
        for sign in (-1.0, 1.0):
            corners = np.roll(np.column_stack([square * (sign, 1.0), np.full(4, sign)]), axis + 1, axis=1)
            normals = np.tile(sign * np.eye(3)[axis], (4, 1))
            sides.append(Shaded(corners * np.array(shape.size) / 2, normals, np.array([(0, 1, 2), (0, 2, 3)])))
    return tuple(sides)


@_surface.register
def _(shape: Loft) -> tuple[Shaded, ...]:
    outline = shape.profile.outline(HALF_TURN, FINEST)
    section, normals = _section(shape.width, shape.exponent)
    mesh = mesh_of_rings(_rings(outline, section))
    return (Shaded(mesh.vertices, _stacked_normals(shape.profile, outline, section, normals), mesh.faces),)


@_surface.register
def _(shape: Compound) -> tuple[Shaded, ...]:
    placed = ((p, part) for p in shape.parts for part in _surface(p.part))
    return tuple(part.placed(p.rotation, np.array(p.at)) for p, part in placed)


@_surface.register
def _(shape: TriangleMesh) -> tuple[Shaded, ...]:
    return (shaded_mesh(shape.vertices, shape.faces),)


def _smooth(shape: Sphere | Ellipsoid | Superquadric, exponent: float) -> tuple[Hull, ...]:
    """One hull, its vertices where the surface has evenly spread normals and where it is evenly far around."""
    half, dual = np.array(shape.extent) / 2, exponent / (exponent - 1.0)
    normals = np.unique(np.round(unit_sphere(HALF_TURN).reshape(-1, 3), 12), axis=0)
    reach = np.linalg.norm(normals * half, ord=dual, axis=1, keepdims=True)
    vertices = np.copysign(half * (np.abs(normals) * half / reach) ** (dual - 1.0), normals)
    margin = ROUND_ENOUGH * _largest_margin(vertices, normals)
    if exponent > 2.0:
        surface = surface_of(shape)
        more = surface.rings(HALF_TURN).reshape(-1, 3)
        vertices, normals = np.concatenate([vertices, more]), np.concatenate([normals, surface.normals(more)])
    return (Hull(vertices - margin * normals, margin),)


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


def _stack(outline: Array, width: float, exponent: float) -> tuple[Hull, ...]:
    """Slices of stacked sections, cut level wherever the outline (r, 2) turns outwards."""
    section, _ = _section(width, exponent)
    rings = _rings(outline, section)
    steps = np.diff(outline, axis=0)
    turns = steps[:-1, 0] * steps[1:, 1] - steps[:-1, 1] * steps[1:, 0]
    straight = 1e-9 * np.hypot(*steps[:-1].T) * np.hypot(*steps[1:].T)
    cuts = [0, *(np.flatnonzero(turns < -straight) + 1).tolist(), len(outline) - 1]
    slices = (rings[low : high + 1].reshape(-1, 3) for low, high in pairwise(cuts))
    return tuple(Hull(np.unique(np.round(vertices, 9), axis=0)) for vertices in slices)
