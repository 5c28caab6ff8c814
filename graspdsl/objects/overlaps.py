"""How much parts of a compound overlap, estimated on lattices of points."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from functools import cache
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from graspdsl.arrays import Array
from graspdsl.objects.compound import Part, Placed
from graspdsl.objects.primitives import Box, Cylinder, Sphere
from graspdsl.objects.solid import solid_of
from graspdsl.objects.triangles import TriangleMesh

LINES, POINTS = 400, 20  # of a lattice, and on each of its lines
NOTABLE = 0.05  # of the smaller part
ROUNDING = 1e-9  # of a volume
AT_ONCE = 4096  # triangles, so that even large ones do not fill the memory
ASIDE = 1e-7 * np.array([np.sqrt(2.0), np.sqrt(3.0)])  # of the size of a mesh: lines of points keep off its edges

Inside = npt.NDArray[np.bool_]
Numbers = npt.NDArray[np.int64]


class Overlap(NamedTuple):
    """Two parts by their numbers, and the volume within both over that of the smaller one."""

    first: int
    second: int
    share: float


def overlaps(parts: Sequence[Placed]) -> Iterator[Overlap]:
    """The pairs that share more than NOTABLE of the smaller part, one after the other, for each takes its time.

    Of pairs whose bounding boxes meet, the smaller part's own box is cut down to what the other reaches of it and
    filled with LINES × POINTS points: exact for two boxes side by side, else good to one or two hundredths. Boxes,
    cylinders and spheres hold the points that they hold in truth; a mesh holds those its mass is counted for: all in
    its convex hull where it has holes, those within its triangles where it is closed.
    """
    axes = np.eye(3)
    high = np.array([[part.support(axis) for axis in axes] for part in parts])
    low = np.array([[-part.support(-axis) for axis in axes] for part in parts])
    meet = ((low[:, None] < high[None]) & (low[None] < high[:, None])).all(axis=-1)
    volumes = [solid_of(part.part).volume for part in parts]

    @cache
    def within(number: int) -> Callable[[Array], Inside]:
        return _within(parts[number].part)

    for first, second in np.argwhere(np.triu(meet, 1)).tolist():
        small, large = sorted((first, second), key=lambda number: volumes[number])
        lines, volume = _lattice(parts[small], parts[large])
        if volume > NOTABLE * volumes[small]:
            shared = within(small)(_seen_from(parts[small], lines)) & within(large)(_seen_from(parts[large], lines))
            share = volume * float(shared.mean()) / volumes[small]
            if share > NOTABLE:
                yield Overlap(first, second, min(share, 1.0))


def _lattice(small: Placed, large: Placed) -> tuple[Array, float]:
    """Lines (LINES, POINTS, 3) of points [m] in what both reach along the axes of the first, and its volume [m³]."""
    rotation, at = small.rotation, np.array(small.at)
    high = np.array([min(part.support(axis) for part in (small, large)) for axis in rotation.T]) - at @ rotation
    low = np.array([max(-part.support(-axis) for part in (small, large)) for axis in rotation.T]) - at @ rotation
    size = np.maximum(high - low, 0.0)
    points = low + size * _unit_lattice()
    return points @ rotation.T + at, float(size.prod())


def _unit_lattice() -> Array:
    """Lines (LINES, POINTS, 3) along z of evenly spread points of the unit cube.

    Multiples of powers of 1/g, where g⁴ = g + 1, modulo 1, spread out evenly in three dimensions without standing in
    rows, which round parts would count unevenly.
    """
    ratio = float(max(np.roots([1.0, 0.0, 0.0, -1.0, -1.0]), key=np.real).real)
    starts = np.arange(1, LINES + 1)[:, None] * ratio ** -np.arange(1.0, 4.0) % 1.0
    heights = (np.arange(POINTS) + starts[:, 2:]) / POINTS
    return np.stack([*np.broadcast_arrays(starts[:, :1], starts[:, 1:2], heights)], axis=-1)


def _seen_from(placed: Placed, points: Array) -> Array:
    seen: Array = (points - np.array(placed.at)) @ placed.rotation
    return seen


def _within(part: Part) -> Callable[[Array], Inside]:
    """Which of the lines of points (l, k, 3), in the frame of the part, are in it."""
    match part:
        case TriangleMesh():
            return _within_mesh(part)
        case Box(size):
            return lambda points: np.array((np.abs(points) < np.array(size) / 2).all(axis=-1))
        case Sphere(diameter):
            return lambda points: np.array(np.linalg.norm(points, axis=-1) < diameter / 2)
        case Cylinder(diameter, height):
            half = np.array([diameter / 2, height / 2])
            return lambda points: np.array((_around_axis(points) < half).all(axis=-1))
    raise TypeError(f"{type(part).__name__} is no part of a URDF")


def _around_axis(points: Array) -> Array:
    """How far points (..., 3) are from the z axis, and from the plane across it, (..., 2)."""
    return np.stack([np.hypot(points[..., 0], points[..., 1]), np.abs(points[..., 2])], axis=-1)


def _within_mesh(mesh: TriangleMesh) -> Callable[[Array], Inside]:
    triangles = mesh.vertices[mesh.faces]
    volume = np.linalg.det(triangles - mesh.vertices.mean(axis=0)).sum() / 6.0
    if abs(volume - mesh.solid.volume) > ROUNDING * mesh.solid.volume:
        from scipy.spatial import ConvexHull

        triangles = mesh.vertices[ConvexHull(mesh.vertices).simplices]
    return lambda lines: _between_triangles(triangles, lines)


def _between_triangles(triangles: Array, lines: Array) -> Inside:
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
    inside: Inside = ahead % 2 == 1
    return inside


def _count(triangles: Array, line: Numbers, starts: Array, heights: Array, ahead: Numbers) -> None:
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
