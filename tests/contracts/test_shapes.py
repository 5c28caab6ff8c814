"""Every shape keeps each rule, and each rule is seen to be broken."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import ClassVar

import numpy as np
import pytest
from graspdsl_stranger.shape import Cup, RoundedCone
from pydantic import ConfigDict, Field

from graspdsl.arrays import Array, Flags
from graspdsl.contracts.rule import Rule
from graspdsl.contracts.shapes import RULES
from graspdsl.objects.ellipsoid import Ellipsoid
from graspdsl.objects.facets import Hull
from graspdsl.objects.mass import Solid
from graspdsl.objects.shading import Shaded
from graspdsl.objects.shape import DescribedShape, Extent, Size, Sizes
from graspdsl.objects.shapes import SHAPES

from .breaking import broken
from .each import each_rule


@each_rule(RULES, "hulls", "solid", "inside", "rests")
@pytest.mark.parametrize("kind", [*SHAPES.values(), Cup], ids=lambda kind: kind.name)
def test_it_keeps_the_rule(kind: type[DescribedShape], rule: Rule[type[DescribedShape]]) -> None:
    assert list(rule(kind)) == []


class Unheld(Cup):
    """A cup."""

    floating_only: ClassVar = ("handle",)


class Stopped(Cup):
    """A cup."""

    about: ClassVar = "a truncated cone."


class WithoutUnit(Cup):
    """A cup."""

    height: Size = Field(description="height", examples=[0.11])


class Lenient(Cup):
    """A cup."""

    model_config = ConfigDict(extra="ignore")


class Larger(Cup):
    """A cup."""

    @property
    def extent(self) -> Extent:
        x, y, z = super().extent
        return (x, y, 1.01 * z)


class Dented(Cup):
    """A cup."""

    def support(self, direction: Array) -> float:
        return super().support(direction) * (1.0 + 0.3 * abs(float(direction[0] * direction[1])))


class Shrunk(Cup):
    """A cup."""

    def inside(self) -> Callable[[Array], Flags]:
        return lambda points: np.asarray(self.surface().level(points) < -0.02)


class Heavy(Cup):
    """A cup."""

    @property
    def solid(self) -> Solid:
        return replace(super().solid, volume=1.05 * super().solid.volume)


class Half(Cup):
    """A cup."""

    def hulls(self) -> tuple[Hull, ...]:
        return tuple(Hull(hull.vertices[hull.vertices[:, 2] > 0.0]) for hull in super().hulls())


class InsideOut(Cup):
    """A cup."""

    def facets(self) -> tuple[Shaded, ...]:
        return tuple(Shaded(part.vertices, -part.normals, part.faces) for part in super().facets())


class Straight(Cup):
    """A cup."""

    @property
    def primitive(self) -> tuple[str, tuple[float, ...]]:
        return "cylinder", (self.bottom / 2, self.height / 2)


class Sharp(Cup):
    """A cup."""

    edged: ClassVar = True


def with_surface(changed: type[RoundedCone]) -> type[Cup]:
    """The cup on another surface."""

    class Changed(Cup):
        """A cup."""

        def surface(self) -> RoundedCone:
            return changed(self.bottom, self.top, self.height, self.edge)

    return Changed


class Inwards(RoundedCone):
    def normals(self, points: Array) -> Array:
        return -super().normals(points)


class Aside(RoundedCone):
    def nearest(self, points: Array) -> Array:
        return super().nearest(1.1 * points)


class Uneven(RoundedCone):
    def sample(self, count: int, random: np.random.Generator) -> Array:
        points = super().sample(2 * count, random)
        return points[np.argsort(points[:, 2])[count:]]


class OneAtATime(RoundedCone):
    def normals(self, points: Array) -> Array:
        return super().normals(points) if points.ndim < 3 else -super().normals(points)


class Egg(Ellipsoid):
    """An egg on its end."""

    rests: ClassVar = True
    size: Sizes = Field(description="lengths (m)", examples=[[0.05, 0.05, 0.09]])


MUTANTS = [
    ("declared", Unheld),
    ("told", Stopped),
    ("keys", WithoutUnit),
    ("round-trip", Lenient),
    ("extent", Larger, "surface"),
    ("support", Dented, "inside", "hulls", "drawn"),
    ("inside", Shrunk, "solid", "hulls"),
    ("solid", Heavy),
    ("hulls", Half),
    ("drawn", InsideOut),
    ("primitive", Straight),
    ("surface", Sharp),
    ("level", with_surface(Inwards), "drawn"),
    ("nearest", with_surface(Aside)),
    ("sample", with_surface(Uneven)),
    ("batches", with_surface(OneAtATime)),
    ("rests", Egg),
]


@pytest.mark.slow
@pytest.mark.parametrize("mutant", MUTANTS, ids=lambda mutant: mutant[0])
def test_a_rule_is_seen_to_be_broken(mutant: tuple[str, type[DescribedShape]]) -> None:
    code, kind, *others = mutant
    assert broken(RULES, kind) == {f"contract-{name}" for name in (code, *others)}


def test_every_rule_is() -> None:
    assert {f"contract-{mutant[0]}" for mutant in MUTANTS} == set(RULES)
