"""What a contact that floats on an object needs to know of the object: a closed surface."""

from __future__ import annotations

from abc import ABC, abstractmethod

import numpy as np

from graspdsl.arrays import Array, namespace, product
from graspdsl.objects.surfaces.mesh import Mesh, mesh_of_rings
from graspdsl.objects.surfaces.vectors import lengths

EPSILON = float(np.finfo(np.float64).eps)
ROUNDING = 64 * EPSILON
STEP = EPSILON ** (1 / 3)  # of the size: there rounding and curvature spoil a central difference alike


class Surface(ABC):
    """A closed smooth surface about the origin, its axis along z, lengths in m.

    Every function takes batches: points (..., 3) with any leading axes; a point's result does not depend on the batch
    that it stands in, except for the last bits of superquadrics (numpy rounds a power of many numbers and of one
    differently). Nowhere is NaN: the centre, the axes and every point where the answer is not unique get one.
    """

    @property
    @abstractmethod
    def extent(self) -> tuple[float, float, float]:
        """Full size along x, y, z [m]."""

    @abstractmethod
    def level(self, points: Array) -> Array:
        """Negative inside, zero on the surface, positive outside [m], (...).

        |level| is never less than the distance to the surface. It is the signed distance itself where the class says
        so, else it has the signed distance's sign only.
        """

    @abstractmethod
    def normals(self, points: Array) -> Array:
        """Outward unit normals [1], (..., 3): exact on the surface, and a smooth field near it."""

    @abstractmethod
    def nearest(self, points: Array) -> Array:
        """Points of the surface [m], (..., 3), exact to rounding: the nearest ones, for points outside of it.

        Points inside go to the nearest as well, except where the class says otherwise.
        """

    @abstractmethod
    def sample(self, count: int, random: np.random.Generator) -> Array:
        """``count`` points (count, 3) [m] spread evenly over the area."""

    @abstractmethod
    def rings(self, count: int) -> Array:
        """Rings (r, s, 3) of points from the lowest point to the highest, ``count`` for each half turn."""

    @property
    def size(self) -> float:
        """The largest extent [m]."""
        return max(self.extent)

    def retract(self, points: Array) -> Array:
        """Points (..., 3) [m] put back on the surface, for instance after a step along the tangent plane.

        For a step t on the tangent plane of x, retract(x + t) = x + t + O(|t|²), the added displacement along the
        normal up to O(|t|³) (a projection-like retraction: Absil and Malick, SIAM J. Optim. 22(1), 2012). Points that
        are on the surface up to rounding, such as retracted ones, stay as they are to the last bit.
        """
        feet = self.nearest(points)
        astray = lengths(feet - points) > ROUNDING * self.size
        return namespace(points).where(astray[..., None], feet, points)

    def shape_operators(self, points: Array) -> Array:
        """S = ∂n/∂x, how the outward normal turns as a point slides over the surface [1/m], (..., 3, 3).

        Symmetric, zero across the surface; on a sphere of radius R it is (I − n nᵀ) / R. By central differences of the
        normals; where two curvatures meet, at the end of a rounding, it is one between them.
        """
        step, each = STEP * self.size, points[..., None, :]
        moved = self.normals(each + step * np.eye(3)) - self.normals(each - step * np.eye(3))
        normals = self.normals(points)
        tangent = np.eye(3) - normals[..., :, None] * normals[..., None, :]
        along: Array = product(product(tangent, moved), tangent) / (2.0 * step)
        symmetric: Array = 0.5 * (along + namespace(along).swapaxes(along, -1, -2))
        return symmetric

    def mesh(self, count: int = 24) -> Mesh:
        """A closed mesh for drawing, with ``count`` edges for each half turn."""
        return mesh_of_rings(self.rings(count))
