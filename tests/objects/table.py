"""Surfaces of every kind, in a few sizes each: from round to flat, from slender to nearly a box."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import pytest

from graspdsl.arrays import Array
from graspdsl.objects.bottle import SmoothBottle
from graspdsl.objects.cylinder import RoundedCylinder
from graspdsl.objects.ellipsoid import SmoothEllipsoid
from graspdsl.objects.sphere import SmoothSphere
from graspdsl.objects.superquadric import SmoothSuperquadric
from graspdsl.objects.surfaces.surface import Surface

SURFACES: Mapping[str, Surface] = {
    "ball": SmoothSphere(0.1),
    "marble": SmoothSphere(0.01),
    "ellipsoid A": SmoothEllipsoid((0.05, 0.06, 0.075)),
    "ellipsoid B": SmoothEllipsoid((0.05, 0.075, 0.11)),
    "ellipsoid of equal axes": SmoothEllipsoid((0.05, 0.05, 0.05)),
    "disc": SmoothEllipsoid((0.1, 0.1, 0.01)),
    "cigar": SmoothEllipsoid((0.01, 0.01, 0.1)),
    "towel roll": RoundedCylinder(0.1, 0.2, 0.005),
    "coin": RoundedCylinder(0.1, 0.02, 0.004),
    "capsule": RoundedCylinder(0.05, 0.2, 0.025),
    "superquadric 2": SmoothSuperquadric((0.05, 0.06, 0.08), 2.0),
    "superquadric 2.5": SmoothSuperquadric((0.05, 0.06, 0.08), 2.5),
    "superquadric 3": SmoothSuperquadric((0.05, 0.06, 0.08), 3.0),
    "superquadric 8": SmoothSuperquadric((0.05, 0.06, 0.08), 8.0),
    "plate": SmoothSuperquadric((0.1, 0.06, 0.01), 4.0),
    "box": SmoothSuperquadric((0.05, 0.05, 0.05), 10.0),
    "bottle": SmoothBottle(0.08, 0.25, 0.03, 0.15, 0.06, 0.02, 0.008),
    "flask": SmoothBottle(0.2, 0.25, 0.06, 0.1, 0.08, 0.03, 0.02),
}
CONVEX = {name: surface for name, surface in SURFACES.items() if not isinstance(surface, SmoothBottle)}
# Superquadrics put points inside only near their nearest point.
EXACT = {name: surface for name, surface in SURFACES.items() if not isinstance(surface, SmoothSuperquadric)}

EACH_SURFACE = pytest.mark.parametrize("surface", SURFACES.values(), ids=SURFACES)
EACH_CONVEX_SURFACE = pytest.mark.parametrize("surface", CONVEX.values(), ids=CONVEX)
EACH_EXACT_SURFACE = pytest.mark.parametrize("surface", EXACT.values(), ids=EXACT)


def generator() -> np.random.Generator:
    """A fresh generator of random numbers."""
    return np.random.default_rng(7)


def tangent_steps(surface: Surface, points: Array, random: np.random.Generator) -> Array:
    """A unit vector along the surface at each of its points (n, 3), in any direction."""
    normals = surface.normals(points)
    vectors = random.normal(size=points.shape)
    vectors -= np.sum(vectors * normals, axis=-1, keepdims=True) * normals
    unit: Array = vectors / np.linalg.norm(vectors, axis=-1, keepdims=True)
    return unit


def special_points(surface: Surface) -> Array:
    """The centre and points on the axes, in the coordinate planes and next to them; inside, on and outside."""
    half = np.array(surface.extent) / 2
    coordinates = [-3.0, -1.0, -0.5, -1e-9, -1e-200, -0.0, 0.0, 5e-324, 1e-30, 0.5, 1.0, 3.0, 1e6]
    return half * np.stack(np.meshgrid(*[coordinates] * 3), axis=-1).reshape(-1, 3)
