"""Geoms in MJCF as the solids that URDF has."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

from graspdsl.arrays import Array
from graspdsl.diagnostics import listed
from graspdsl.hands.mjcf_known import HINTS
from graspdsl.hands.mjcf_parts import HERE, Angles, Part, Pose, least_turn

SIZES = {"sphere": 1, "capsule": 2, "cylinder": 2, "box": 3}
MOST_SIZES = 3


class GeomSolid(NamedTuple):
    """A sphere, cylinder or box: its tag and attributes in URDF, and where it is in the frame of its geom."""

    tag: str
    sizes: Mapping[str, str]
    pose: Pose


def solids_of(geom: Part, angles: Angles) -> list[GeomSolid]:
    """The solids of a geom, three of a capsule. Raises DiagnosticError for a kind that is not read."""
    kind = geom.attributes.get("type", "sphere")
    if kind not in SIZES:
        message = f"a geom of type {kind!r} is not read: only {listed(SIZES)}"
        raise geom.refused(message, HINTS["mesh"])
    drawn = "fromto" in geom.attributes
    if drawn and kind == "sphere":
        raise geom.refused("a sphere has no fromto", "give it a pos")
    if drawn and "pos" in geom.attributes:
        raise geom.refused("it has a pos and a fromto", "keep one of them")
    needed = 1 if drawn else SIZES[kind]
    size = geom.numbers("size", "", *range(needed, MOST_SIZES + 1))
    pose = angles.pose(geom)
    if drawn:
        pose, half = _between(geom)
        size = np.array([size[0], size[0], half] if kind == "box" else [size[0], half])
    size = size[: SIZES[kind]]
    if size.min() <= 0.0:
        raise geom.refused(f"its size is not positive: {geom.attributes['size']!r}", None)
    return _solids(kind, size, pose)


def weighs(geom: Part) -> bool:
    """Whether a geom gives its body mass where that has no inertia of its own: unless it says otherwise, it does."""
    return geom.number("mass" if "mass" in geom.attributes else "density", "1000") != 0.0


def _between(geom: Part) -> tuple[Pose, float]:
    """Where a geom between two points is, and half of its length [m]: its z axis goes to the first of them."""
    ends = geom.numbers("fromto", "", 6).reshape(2, 3)
    along = ends[0] - ends[1]
    return Pose(ends.mean(axis=0), least_turn(geom.direction("fromto", along))), float(np.linalg.norm(along)) / 2.0


def _solids(kind: str, size: Array, pose: Pose) -> list[GeomSolid]:
    if kind == "box":
        return [GeomSolid("box", {"size": " ".join(repr(2.0 * edge) for edge in size.tolist())}, pose)]
    radius = {"radius": repr(float(size[0]))}
    if kind == "sphere":
        return [GeomSolid("sphere", radius, pose)]
    tube = GeomSolid("cylinder", {**radius, "length": repr(2.0 * float(size[1]))}, pose)
    ends = [pose.then(Pose(np.array([0.0, 0.0, end]), HERE.turned)) for end in (size[1], -size[1])]
    return [tube] if kind == "cylinder" else [tube, *(GeomSolid("sphere", radius, end) for end in ends)]
