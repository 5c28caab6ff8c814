"""Surfaces of revolution."""

from __future__ import annotations

from abc import abstractmethod
from functools import cached_property

import numpy as np

from graspdsl.arrays import Array, namespace, packed
from graspdsl.objects.surfaces.mesh import turned
from graspdsl.objects.surfaces.profile import Profile
from graspdsl.objects.surfaces.surface import Surface


class Revolution(Surface):
    """The surface that a profile of lines and arcs sweeps about z.

    The nearest point to a point lies in the half plane through it and the axis, so the profile's own nearest point
    gives exact normals, the exact signed distance (``level``) and exact retraction, in closed form: no step of an
    iteration can miss a narrow neck or a sharp edge. Where a profile is hollow, at a bottle's throat, points farther
    out than the hollow's radius have more than one nearest point, and one of them is taken.
    """

    def __post_init__(self) -> None:
        _ = self.profile  # an impossible profile is refused here and not at its first use

    @cached_property
    @abstractmethod
    def profile(self) -> Profile:
        """The curve that is turned about the axis [m]."""

    @property
    def extent(self) -> tuple[float, float, float]:
        """Full size along x, y, z [m]."""
        width, height = 2 * self.profile.reach(1.0, 0.0), self.profile.reach(0.0, 1.0) + self.profile.reach(0.0, -1.0)
        return (width, width, height)

    def level(self, points: Array) -> Array:
        """The signed distance to the surface [m], (...)."""
        planar, _ = _planar(points)
        feet, normals = self.profile.nearest(planar)
        gaps = (planar - feet) * normals
        distances: Array = gaps[:, 0] + gaps[:, 1]
        return distances.reshape(points.shape[:-1])

    def normals(self, points: Array) -> Array:
        """The outward unit normals at the nearest points of the surface, (..., 3)."""
        planar, azimuths = _planar(points)
        _, normals = self.profile.nearest(planar)
        return _spatial(normals, azimuths).reshape(points.shape)

    def nearest(self, points: Array) -> Array:
        """The nearest points of the surface (..., 3) [m]."""
        planar, azimuths = _planar(points)
        feet, _ = self.profile.nearest(planar)
        return _spatial(feet, azimuths).reshape(points.shape)

    def sample(self, count: int, random: np.random.Generator) -> Array:
        """Points of the profile, denser the farther from the axis, at any azimuth: (count, 3) [m]."""
        angles = random.uniform(-np.pi, np.pi, count)
        return _spatial(self.profile.sample(count, random), np.stack([np.cos(angles), np.sin(angles)], axis=-1))

    def rings(self, count: int) -> Array:
        """Circles of latitude (r, 2 count, 3) [m]."""
        return turned(self.profile.outline(count), 2 * count)


def _planar(points: Array) -> tuple[Array, Array]:
    """Points (..., 3) as (ρ, z), (n, 2), and unit vectors (n, 2) of their azimuths; along x for those on the axis."""
    xp, flat = namespace(points), points.reshape(-1, 3)
    radius = xp.hypot(flat[:, 0], flat[:, 1])
    off_axis = radius[:, None] > 0.0
    azimuths = xp.where(off_axis, flat[:, :2] / xp.where(off_axis, radius[:, None], 1.0), np.array([1.0, 0.0]))
    return packed(radius, flat[:, 2]), azimuths


def _spatial(planar: Array, azimuths: Array) -> Array:
    """(ρ, z) and azimuths, (n, 2) each, as (n, 3)."""
    return namespace(planar).concatenate([planar[:, :1] * azimuths, planar[:, 1:]], axis=-1)
