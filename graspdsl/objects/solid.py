"""Volume, centre of mass and inertia of shapes of even density."""

from __future__ import annotations

import math
from functools import singledispatch

import numpy as np

from graspdsl.objects.compound import Compound, Loft
from graspdsl.objects.mass import Solid, joined
from graspdsl.objects.primitives import Bottle, Box, Cylinder, Ellipsoid, Extent, Sphere, Superquadric
from graspdsl.objects.surfaces.profile import Profile
from graspdsl.objects.triangles import TriangleMesh

OUTLINE = 400  # lines for a half turn of an arc: the volume of a ball so drawn is off by 2e-5


@singledispatch
def solid_of(shape: object) -> Solid:
    """The integrals of a shape in its own frame; closed forms, along curved outlines by fine straight pieces."""
    raise TypeError(f"{type(shape).__name__} is no shape")


@solid_of.register
def _(shape: Sphere) -> Solid:
    return _symmetric(math.pi / 6 * shape.diameter**3, shape.extent, 1 / 20)


@solid_of.register
def _(shape: Ellipsoid) -> Solid:
    return _symmetric(math.pi / 6 * math.prod(shape.size), shape.size, 1 / 20)


@solid_of.register
def _(shape: Box) -> Solid:
    return _symmetric(math.prod(shape.size), shape.size, 1 / 12)


@solid_of.register
def _(shape: Cylinder) -> Solid:
    across, along = shape.diameter**2 / 16, shape.height**2 / 12
    volume = math.pi / 4 * shape.diameter**2 * shape.height
    return Solid(volume, np.zeros(3), volume * np.diag([across, across, along]))


@solid_of.register
def _(shape: Superquadric) -> Solid:
    volume = math.prod(shape.size) * _dirichlet(shape.exponent, 1, 1, 1)
    share = _dirichlet(shape.exponent, 3, 1, 1) / _dirichlet(shape.exponent, 1, 1, 1) / 4
    return _symmetric(volume, shape.size, share)


@solid_of.register
def _(shape: Bottle) -> Solid:
    return _stack(shape.profile, 1.0, 2.0)


@solid_of.register
def _(shape: Loft) -> Solid:
    return _stack(shape.profile, shape.width, shape.exponent)


@solid_of.register
def _(shape: Compound) -> Solid:
    return joined(solid_of(p.part).placed(p.rotation, np.array(p.at)) for p in shape.parts)


@solid_of.register
def _(shape: TriangleMesh) -> Solid:
    return shape.solid


def _symmetric(volume: float, size: Extent, share: float) -> Solid:
    """A volume about the origin with ∫ x² dV = share · V · size²."""
    return Solid(volume, np.zeros(3), share * volume * np.diag(np.square(size)))


def _dirichlet(exponent: float, *powers: int) -> float:
    """∫ Π x_i^(α_i − 1) dx over Σ x_i^p ≤ 1, x_i ≥ 0: Π Γ(α_i/p) / (p^m Γ(1 + Σ α_i/p)), Dirichlet's integral."""
    product = math.prod(math.gamma(power / exponent) / exponent for power in powers)
    return product / math.gamma(1.0 + sum(powers) / exponent)


def _stack(profile: Profile, width: float, exponent: float) -> Solid:
    """Sections |x/ρ|^n + |y/(wρ)|^n ≤ 1 over the outline ρ(z): Gauss's rule, exact for each straight piece."""
    outline = profile.outline(OUTLINE)
    nodes, weights = np.polynomial.legendre.leggauss(3)
    low, high = outline[:-1, None], outline[1:, None]
    points = (low + high) / 2 + (high - low) / 2 * nodes[None, :, None]
    rho, z, heights = points[..., 0], points[..., 1], (high - low)[..., 1] / 2 * weights
    area = 4.0 * width * _dirichlet(exponent, 1, 1) * rho**2 * heights
    spread = 4.0 * _dirichlet(exponent, 3, 1) * rho**4 * heights
    volume = float(area.sum())
    middle = float((area * z).sum()) / volume
    moments = np.diag([width * spread.sum(), width**3 * spread.sum(), (area * (z - middle) ** 2).sum()])
    return Solid(volume, np.array([0.0, 0.0, middle]), moments)
