"""Half of a planar cut through a body of revolution: straight lines joined by circular arcs."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
import numpy.typing as npt

from graspdsl.arrays import Array, namespace, packed
from graspdsl.objects.surfaces.sampling import accepted

Pair = tuple[float, float]


@dataclass(frozen=True, eq=False, slots=True)
class Lines:
    """l lines: start (l, 2), direction (l, 2) and length (l,), the inside to the left."""

    start: Array
    direction: Array
    length: Array


@dataclass(frozen=True, eq=False, slots=True)
class Arcs:
    """a arcs: centre (a, 2), radius (a,), direction (a, 2) from the centre to the arc's middle, half of its angle (a,).

    ``side`` (a,) is +1 where the inside is that of the circle, −1 where the arc is a hollow.
    """

    centre: Array
    radius: Array
    middle: Array
    half: Array
    side: Array

    def at(self, arc: npt.NDArray[np.int64] | slice, shares: Array) -> Array:
        """Points (..., 2) of arcs at shares from −1, where the arc begins, to 1, where it ends."""
        angles = np.arctan2(self.middle[arc, 1], self.middle[arc, 0]) + shares * (self.side * self.half)[arc]
        points: Array = self.centre[arc] + self.radius[arc, None] * np.stack([np.cos(angles), np.sin(angles)], axis=-1)
        return points


@dataclass(frozen=True, eq=False, slots=True)
class Profile:
    """A curve of lines and arcs in the half plane (ρ, z), ρ ≥ 0 the distance from the axis [m].

    It runs from the axis, at the bottom, to the axis again, at the top, with the inside to its left, and meets the
    axis at a right angle. Lines and arcs alternate and share their tangents where they meet: the curve is C1, and the
    nearest point is found in closed form.
    """

    lines: Lines
    arcs: Arcs

    def reach(self, rho: float, z: float) -> float:
        """How far the curve goes in the direction of the unit vector (ρ, z) [m]."""
        direction = np.array([rho, z])
        ends = np.concatenate([self.lines.start, self.lines.start + self.lines.length[:, None] * self.lines.direction])
        in_arc = self.arcs.middle @ direction >= np.cos(self.arcs.half)
        bulges = np.where(in_arc & (self.arcs.side > 0.0), self.arcs.centre @ direction + self.arcs.radius, -np.inf)
        return float(max((ends @ direction).max(), bulges.max()))

    def nearest(self, points: Array) -> tuple[Array, Array]:
        """The nearest points of the curve and its outward normals there, (n, 2) each, for points (n, 2) with ρ ≥ 0."""
        xp, lines, arcs = namespace(points), self.lines, self.arcs
        x, y = points[:, 0], points[:, 1]

        away_x, away_y = x - lines.start[:, :1], y - lines.start[:, 1:]
        forward_x, forward_y = lines.direction[:, :1], lines.direction[:, 1:]
        along = xp.minimum(xp.maximum(away_x * forward_x + away_y * forward_y, 0.0), lines.length[:, None])
        line_x, line_y = lines.start[:, :1] + along * forward_x, lines.start[:, 1:] + along * forward_y
        line_gaps = (x - line_x) ** 2 + (y - line_y) ** 2

        away_x, away_y = x - arcs.centre[:, :1], y - arcs.centre[:, 1:]
        distance = xp.hypot(away_x, away_y)
        on_arc = away_x * arcs.middle[:, :1] + away_y * arcs.middle[:, 1:] >= distance * np.cos(arcs.half)[:, None]
        # Off the arc its nearest point is an end, which a line has too.
        arc_gaps = xp.where(on_arc, (distance - arcs.radius[:, None]) ** 2, np.inf)

        # Of all of them the nearest; only its point is worked out for an arc.
        line, arc, every = xp.argmin(line_gaps, axis=0), xp.argmin(arc_gaps, axis=0), np.arange(len(points))
        is_arc = arc_gaps[arc, every] < line_gaps[line, every]
        reach = distance[arc, every]
        away = packed(away_x[arc, every], away_y[arc, every])
        middle, centre, radius, side, ahead = (
            xp.take(of_each, place, axis=0)
            for of_each, place in ((arcs.middle, arc), (arcs.centre, arc), (arcs.radius[:, None], arc),
                                   (arcs.side[:, None], arc), (lines.direction, line))
        )  # fmt: skip
        outward = xp.where(reach[:, None] > 0.0, away / xp.where(reach > 0.0, reach, 1.0)[:, None], middle)
        on_line = packed(line_x[line, every], line_y[line, every])
        feet = xp.where(is_arc[:, None], centre + radius * outward, on_line)
        return feet, xp.where(is_arc[:, None], side * outward, packed(ahead[:, 1], -ahead[:, 0]))

    def sample(self, count: int, random: np.random.Generator) -> Array:
        """Points (count, 2) of the curve with density in proportion to ρ: even over the area that it sweeps."""
        lines, arcs = self.lines, self.arcs
        line_ends = lines.start[:, 0] + lines.length * lines.direction[:, 0]
        widest = np.concatenate([np.maximum(lines.start[:, 0], line_ends), arcs.centre[:, 0] + arcs.radius])
        bound = widest * np.concatenate([lines.length, 2.0 * arcs.radius * arcs.half])

        def draw(number: int, random: np.random.Generator) -> tuple[Array, Array]:
            piece, share = random.choice(len(bound), number, p=bound / bound.sum()), random.random(number)
            line, arc = np.minimum(piece, len(lines.length) - 1), np.maximum(piece - len(lines.length), 0)
            on_line = lines.start[line] + (share * lines.length[line])[:, None] * lines.direction[line]
            on_arc = arcs.at(arc, 2.0 * share - 1.0)
            points = np.where((piece < len(lines.length))[:, None], on_line, on_arc)
            return points, points[:, 0] / widest[piece]

        return accepted(count, random, draw)

    def outline(self, count: int, finest: float = 0.0) -> Array:
        """Points (n, 2) along the curve, ``count`` for each half turn of an arc, but no nearer than ``finest`` [m]."""
        parts = [self.lines.start[:1]]
        for arc, half in enumerate(self.arcs.half):
            share = 2.0 * half / np.pi
            most = np.pi * share * self.arcs.radius[arc] / finest if finest > 0.0 else np.inf
            steps = max(1, int(np.ceil(min(count * share, most))))
            parts.append(self.arcs.at(slice(arc, arc + 1), np.linspace(-1.0, 1.0, steps + 1)))
        parts.append(self.lines.start[-1:] + self.lines.length[-1:, None] * self.lines.direction[-1:])
        points = np.concatenate(parts)
        steps_between = np.hypot(*np.diff(points, axis=0).T)
        apart = np.concatenate([[True], steps_between > 1e-9 * steps_between.max()])
        different: Array = points[apart]
        return different


def rounded(corners: tuple[Pair, ...], radii: tuple[float, ...]) -> Profile:
    """The profile along a chain of corners (ρ, z) [m], with an arc of the given radius [m] in place of each inner one.

    The chain begins and ends on the axis, with edges at a right angle to it, and has its inside to the left.
    """
    chain = np.array(corners)
    if len(radii) != len(corners) - 2 or len(radii) < 1:
        raise ValueError(f"{len(corners)} corners need {len(corners) - 2} radii, not {len(radii)}")
    if not min(radii) > 0.0:
        raise ValueError(f"the radii of edges must be positive, not {radii}")
    if (
        chain[[0, -1], 0].any()
        or chain[0, 1] != chain[1, 1]
        or chain[-1, 1] != chain[-2, 1]
        or chain[1:-1, 0].min() <= 0
    ):
        raise ValueError(f"a profile begins and ends at right angles to the axis and keeps off it between: {corners}")
    edges = np.diff(chain, axis=0)
    edge_lengths = np.hypot(edges[:, 0], edges[:, 1])
    if not edge_lengths.min() > 0.0:
        raise ValueError(f"the same corner twice in a row: {corners}")
    ahead = edges / edge_lengths[:, None]
    left = np.stack([-ahead[:, 1], ahead[:, 0]], axis=-1)

    radius = np.array(radii)
    turns = np.array([np.arctan2(a[0] * b[1] - a[1] * b[0], a @ b) for a, b in pairwise(ahead)])
    side = np.where(turns < 0.0, -1.0, 1.0)
    cut = radius * np.tan(np.abs(turns) / 2)
    begin, end = np.concatenate([[0.0], cut]), np.concatenate([cut, [0.0]])
    lengths = edge_lengths - begin - end
    if lengths.min() < -1e-9 * edge_lengths.max():
        raise ValueError(f"edges of radius {radii} leave no room for each other between the corners {corners}")

    bisector = left[:-1] + left[1:]
    middle = -side[:, None] * bisector / np.hypot(bisector[:, 0], bisector[:, 1])[:, None]
    centre = chain[1:-1] - cut[:, None] * ahead[:-1] + (side * radius)[:, None] * left[:-1]
    return Profile(
        Lines(chain[:-1] + begin[:, None] * ahead, ahead, np.maximum(lengths, 0.0)),
        Arcs(centre, radius, middle, np.abs(turns) / 2, side),
    )
