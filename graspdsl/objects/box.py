"""The box."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import ClassVar

import numpy as np
from pydantic import Field

from graspdsl.arrays import Array, Flags
from graspdsl.objects.facets import Hull
from graspdsl.objects.mass import Solid, symmetric
from graspdsl.objects.shading import Shaded
from graspdsl.objects.shape import DescribedShape, Extent, Sizes


class Box(DescribedShape):
    """A box with edges along the axes of the world."""

    name: ClassVar = "box"
    about: ClassVar = "a box"
    upright: ClassVar = False
    edged: ClassVar = True
    rests: ClassVar = True

    size: Sizes = Field(
        description="lengths of the edges along x, y and z (m), 0.005 to 2 each", examples=[[0.06, 0.06, 0.20]]
    )

    @property
    def extent(self) -> Extent:
        """Full size along x, y, z [m]."""
        return self.size

    @property
    def primitive(self) -> tuple[str, tuple[float, ...]]:
        """A box of three half sizes."""
        return "box", tuple(length / 2 for length in self.size)

    @property
    def solid(self) -> Solid:
        """V = x y z, ∫ x² dV = V x² / 12."""
        return symmetric(math.prod(self.size), self.size, 1 / 12)

    def support(self, direction: Array) -> float:
        """Σ |d_i| x_i / 2."""
        return float(np.abs(direction) @ np.array(self.size) / 2)

    def facets(self) -> tuple[Shaded, ...]:
        """Six sides."""
        square = np.array([(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)])
        sides = []
        for axis in range(3):
            for sign in (-1.0, 1.0):
                corners = np.roll(np.column_stack([square * (sign, 1.0), np.full(4, sign)]), axis + 1, axis=1)
                normals = np.tile(sign * np.eye(3)[axis], (4, 1))
                sides.append(Shaded(corners * np.array(self.size) / 2, normals, np.array([(0, 1, 2), (0, 2, 3)])))
        return tuple(sides)

    def hulls(self) -> tuple[Hull, ...]:
        """Eight corners."""
        signs = np.stack(np.meshgrid(*[(-0.5, 0.5)] * 3), axis=-1).reshape(-1, 3)
        return (Hull(signs * np.array(self.size)),)

    def inside(self) -> Callable[[Array], Flags]:
        """Between its sides."""
        half = np.array(self.size) / 2
        return lambda points: np.array((np.abs(points) < half).all(axis=-1))
