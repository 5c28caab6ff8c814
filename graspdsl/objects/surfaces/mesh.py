"""Triangles for drawing."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from graspdsl.arrays import Array


@dataclass(frozen=True, eq=False, slots=True)
class Mesh:
    """A closed mesh: vertices (v, 3) [m] and faces (f, 3) by vertex number, counter-clockwise seen from outside."""

    vertices: Array
    faces: npt.NDArray[np.int64]


def mesh_of_rings(rings: Array) -> Mesh:
    """The mesh through rings (r, s, 3) from the lowest to the highest, each counter-clockwise seen from above.

    The first and the last ring are a point each, said s times.
    """
    inner, around = len(rings) - 2, rings.shape[1]
    number = 1 + np.arange(inner * around).reshape(inner, around)
    following = np.roll(number, -1, axis=1)
    low, low_next, high, high_next = number[:-1], following[:-1], number[1:], following[1:]
    bottom, top = np.zeros(around, dtype=np.int64), np.full(around, 1 + inner * around)
    corners = (
        (bottom, following[0], number[0]),
        (low, low_next, high_next),
        (low, high_next, high),
        (number[-1], following[-1], top),
    )
    faces = np.concatenate([np.stack([part.ravel() for part in triple], axis=-1) for triple in corners])
    return Mesh(np.concatenate([rings[0, :1], rings[1:-1].reshape(-1, 3), rings[-1, :1]]), faces)


def turned(outline: Array, around: int) -> Array:
    """Rings (r, around, 3) of an outline (r, 2) of distances from the axis and heights, turned about z."""
    angles = 2 * np.pi * np.arange(around) / around
    shape = (len(outline), around)
    return np.stack(
        [
            outline[:, :1] * np.cos(angles),
            outline[:, :1] * np.sin(angles),
            np.broadcast_to(outline[:, 1:], shape),
        ],
        axis=-1,
    )


def unit_sphere(count: int) -> Array:
    """Rings (count + 1, 2 count, 3) of the unit sphere, at even steps of latitude."""
    latitudes = np.linspace(-np.pi / 2, np.pi / 2, count + 1)
    radii = np.cos(latitudes)
    radii[[0, -1]] = 0.0
    return turned(np.stack([radii, np.sin(latitudes)], axis=-1), 2 * count)
