"""What every part of graspdsl may ask of the shape of an object."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Callable
from functools import cache
from typing import Annotated, ClassVar

import numpy as np
from pydantic import Field

from graspdsl.arrays import Array, Flags
from graspdsl.objects.facets import HALF_TURN, Hull
from graspdsl.objects.mass import Solid
from graspdsl.objects.shading import Shaded
from graspdsl.objects.surfaces.surface import Surface
from graspdsl.places.fields import Metres, Model, exactly

Extent = tuple[float, float, float]
LONGEST, SHORTEST = 2.0, 0.005  # m
Size = Annotated[Metres, Field(ge=SHORTEST, le=LONGEST)]
Sizes = Annotated[tuple[Size, Size, Size], exactly(3, "[x, y, z]: three lengths (m)")]
Rounding = Annotated[Metres, Field(gt=0.0, le=1.0)]
CLEARLY_LONGER = 1.05
SLANTING = math.sqrt(0.5)  # the sine of an angle
UPRIGHT: Extent = (0.0, 0.0, 1.0)


class Shape(ABC):
    """A solid of even density about the origin, its axis along z, lengths in m.

    ``name``: what messages call it. ``edged``: it has edges, on which a contact that floats has no normal. ``convex``:
    a hand can take it only as a whole. ``upright``: its z axis is its major axis, however long the others are.
    ``rests``: it stays as it is put down. ``rolls``: it may, and never leans.
    """

    name: ClassVar[str]
    edged: ClassVar[bool] = False
    convex: ClassVar[bool] = True
    upright: ClassVar[bool] = True
    rests: ClassVar[bool] = False
    rolls: ClassVar[bool] = False

    @property
    @abstractmethod
    def extent(self) -> Extent:
        """Full size along x, y, z [m]."""

    @property
    @abstractmethod
    def solid(self) -> Solid:
        """Its integrals in its own frame; in closed form, along curved outlines by fine straight pieces.

        Raises ValueError when its sizes do not go together.
        """

    @abstractmethod
    def support(self, direction: Array) -> float:
        """How far it reaches from its origin along a unit vector (3,) [m]."""

    @property
    def major_axis(self) -> Extent:
        """The unit vector, in its frame, against which orientations are reported: z, or the axis of the longest extent
        of a shape that is not upright by nature, where that is clearly the longest."""
        extent = self.extent
        _, second, longest = sorted(extent)
        if self.upright or longest <= CLEARLY_LONGER * second:
            return UPRIGHT
        x, y, z = (float(size == longest) for size in extent)
        return (x, y, z)

    @property
    def axle(self) -> Extent | None:
        """The unit vector, in its frame, about which it is round, as it rolls and does not lean; None where it is not
        round, or wherever it is looked at from."""
        return None

    @property
    def lies_round(self) -> bool:
        """Whether it is put down on its round side, on which it may roll without leaning."""
        return self.axle is not None and abs(self.axle[2]) < SLANTING

    @property
    def primitive(self) -> tuple[str, tuple[float, ...]] | None:
        """What engines know it as, with its half sizes [m]: ("box", (x, y, z)), ("sphere", (r,)), ("cylinder", (r, z)).

        None for what an engine has no shape of its own for: there its ``hulls`` collide.
        """
        return None

    def surface(self) -> Surface:
        """The closed smooth surface for contacts that float on it.

        Raises ValueError for edges, and when sizes and roundings do not go together.
        """
        raise ValueError(f"{self.name} has sharp edges, on which a contact has no normal")

    def facets(self) -> tuple[Shaded, ...]:
        """Its surface for drawing, in its own frame."""
        surface = self.surface()
        mesh = surface.mesh(HALF_TURN)
        return (Shaded(mesh.vertices, surface.normals(mesh.vertices), mesh.faces),)

    def hulls(self) -> tuple[Hull, ...]:
        """Convex polyhedra that together fill it, in its own frame."""
        return (Hull(np.concatenate([part.vertices for part in self.facets()])),)

    def inside(self) -> Callable[[Array], Flags]:
        """Which of the points (l, k, 3) [m] of parallel lines are in it, (l, k)."""
        surface = self.surface()
        return lambda points: np.asarray(surface.level(points) < 0.0)


class DescribedShape(Shape, Model):
    """A shape that a few numbers describe, which are its keys in a spec.

    ``about``: what the spec's reference says of it. ``floating_only``: the keys that matter only where contacts float.
    """

    about: ClassVar[str]
    floating_only: ClassVar[tuple[str, ...]] = ()


@cache
def convex_parts(shape: Shape) -> tuple[Hull, ...]:
    """Convex polyhedra that together fill a shape, in its own frame."""
    return shape.hulls()


@cache
def shaded(shape: Shape) -> tuple[Shaded, ...]:
    """The surface of a shape for drawing, in its own frame."""
    return shape.facets()
