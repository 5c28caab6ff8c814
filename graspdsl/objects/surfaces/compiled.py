"""A surface whose contacts are moved by compiled functions."""

from __future__ import annotations

import numpy as np

from graspdsl.arrays import Array
from graspdsl.backends import Backend
from graspdsl.objects.surfaces.surface import Surface


def compiled(surface: Surface, backend: Backend) -> Surface:
    """The surface, with the normals and retractions of contacts that slide over it, which are loops, as a backend that
    gains by these computes them."""
    return _Compiled(surface, backend) if backend.loops else surface


class _Compiled(Surface):
    """Of many trials, contacts (..., k, 3), k of each, are worked on as in one function of a trial."""

    def __init__(self, surface: Surface, backend: Backend) -> None:
        self.surface = surface
        self._normals = backend.compiled(lambda call, points: (call(surface.normals, points),))
        self._retracted = backend.compiled(lambda call, points: (call(surface.retract, points),))

    @property
    def extent(self) -> tuple[float, float, float]:
        """Full size along x, y, z [m]."""
        return self.surface.extent

    def level(self, points: Array) -> Array:
        """As of the surface [m], (...)."""
        return self.surface.level(points)

    def normals(self, points: Array) -> Array:
        """The outward unit normals, (..., 3)."""
        (normals,) = self._normals(points.shape[:-2], points)
        return normals

    def nearest(self, points: Array) -> Array:
        """The nearest points of the surface (..., 3) [m]."""
        return self.surface.nearest(points)

    def retract(self, points: Array) -> Array:
        """Points (..., 3) [m] put back on the surface."""
        (points,) = self._retracted(points.shape[:-2], points)
        return points

    def sample(self, count: int, random: np.random.Generator) -> Array:
        """Points spread evenly over the area, (count, 3) [m]."""
        return self.surface.sample(count, random)

    def rings(self, count: int) -> Array:
        """Rings (r, s, 3) of points."""
        return self.surface.rings(count)
