"""Samples are spread evenly over the area."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
from scipy.stats import chi2, norm

from graspdsl.arrays import Array
from graspdsl.objects.bottle import SmoothBottle
from graspdsl.objects.surfaces.surface import Surface

from .table import EACH_SURFACE, generator

CHANCE = 1e-7  # that a right sampler fails one of these tests
SECTORS, BANDS = 7, 9


def _refined(rings: Array, size: float) -> Array:
    """Rings with straight ones put between those farther apart than size / 200: a cone stays a cone."""
    parts = []
    for low, high in pairwise(rings):
        steps = int(np.ceil(200 * np.linalg.norm(high - low, axis=-1).max() / size))
        parts.append(low + np.arange(max(1, steps))[:, None, None] / max(1, steps) * (high - low))
    return np.concatenate([*parts, rings[-1:]])


def _patches(surface: Surface) -> tuple[Array, Array]:
    """Centres (n, 3) and areas (n,) of small patches that cover the surface."""
    rings = _refined(surface.rings(200), surface.size)
    following = np.roll(rings, -1, axis=1)
    corners = (rings[:-1], following[:-1], following[1:], rings[1:])
    area = np.linalg.norm(np.cross(corners[2] - corners[0], corners[3] - corners[1]), axis=-1) / 2
    return (sum(corners) / 4).reshape(-1, 3), area.ravel()


def _elevations(surface: Surface, points: Array) -> Array:
    scaled = points / np.array(surface.extent)
    return np.arctan2(scaled[:, 2], np.hypot(scaled[:, 0], scaled[:, 1]))


def _bins(surface: Surface, points: Array, limits: Array) -> Array:
    """The number of each point's bin: sectors of azimuth, turned off the planes of symmetry, and bands of elevation."""
    sector = ((np.arctan2(points[:, 1], points[:, 0]) + 0.3) / (2 * np.pi) * SECTORS) % SECTORS
    bands = np.searchsorted(limits, _elevations(surface, points))
    return sector.astype(int) * BANDS + bands


@EACH_SURFACE
def test_samples_are_even_over_the_area(surface: Surface) -> None:
    centres, areas = _patches(surface)
    order = np.argsort(_elevations(surface, centres))
    quantiles = np.searchsorted(np.cumsum(areas[order]) / areas.sum(), np.arange(1, BANDS) / BANDS)
    limits = _elevations(surface, centres)[order][quantiles]
    count = 20_000
    expected = np.bincount(_bins(surface, centres, limits), areas, SECTORS * BANDS) / areas.sum() * count
    observed = np.bincount(_bins(surface, surface.sample(count, generator()), limits), minlength=SECTORS * BANDS)
    assert expected.min() > 20
    assert np.sum((observed - expected) ** 2 / expected) < chi2.isf(CHANCE, SECTORS * BANDS - 1)


@EACH_SURFACE
def test_samples_are_symmetric(surface: Surface) -> None:
    points = surface.sample(20_000, generator())
    means = points.mean(axis=0) / (points.std(axis=0) / np.sqrt(len(points)))
    symmetric = means[:2] if isinstance(surface, SmoothBottle) else means
    assert np.abs(symmetric).max() < norm.isf(CHANCE / 6)


@EACH_SURFACE
def test_samples_follow_their_generator(surface: Surface) -> None:
    np.testing.assert_array_equal(surface.sample(100, generator()), surface.sample(100, generator()))
    random = generator()
    first, second = surface.sample(100, random), surface.sample(100, random)
    assert not np.any(np.all(first == second, axis=-1))


@EACH_SURFACE
def test_as_many_samples_as_asked(surface: Surface) -> None:
    for count in (0, 1, 63, 1000):
        assert surface.sample(count, generator()).shape == (count, 3)
