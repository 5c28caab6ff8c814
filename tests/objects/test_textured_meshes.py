"""OBJ files whose faces have textures and normals of their own are as closed as without."""

from __future__ import annotations

from itertools import pairwise, product

import numpy as np
import pytest

from graspdsl.arrays import Array
from graspdsl.diagnostics import Diagnostic
from graspdsl.objects.mesh_files import mesh_of_file

from .parts import textured

CUBE = np.array(list(product((0.0, 0.1), (0.0, 0.2), (0.0, 0.3))))
SQUARES = ((0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3))
RADIUS, AROUND, RINGS = 0.05, 12, 8


def _globe() -> tuple[Array, list[tuple[int, ...]]]:
    """Rings of quadrilaterals; those at the poles have two corners at the pole, each written on its own."""
    latitudes = np.linspace(-np.pi / 2, np.pi / 2, RINGS + 1)
    angles = 2 * np.pi * np.arange(AROUND) / AROUND
    rings = [
        [(c * np.cos(angle), c * np.sin(angle), s) for angle in angles]
        for c, s in zip(np.cos(latitudes).round(12), np.sin(latitudes), strict=True)
    ]
    faces = [
        (low + i, low + (i + 1) % AROUND, high + (i + 1) % AROUND, high + i)
        for low, high in pairwise(range(0, AROUND * (RINGS + 1), AROUND))
        for i in range(AROUND)
    ]
    return RADIUS * np.array(rings).reshape(-1, 3), faces


def _globe_volume() -> float:
    """Frustums of even polygons of area A = n/2 ρ² sin 2π/n: h/3 (A + A' + √(A A'))."""
    latitudes = np.linspace(-np.pi / 2, np.pi / 2, RINGS + 1)
    areas = AROUND / 2 * np.sin(2 * np.pi / AROUND) * (RADIUS * np.cos(latitudes)) ** 2
    heights = np.diff(RADIUS * np.sin(latitudes))
    return float((heights / 3 * (areas[:-1] + areas[1:] + np.sqrt(areas[:-1] * areas[1:]))).sum())


def _read(text: str) -> tuple[float, list[str]]:
    """The volume [m³] of an OBJ file, and what is said of it."""
    said: list[Diagnostic] = []
    mesh = mesh_of_file("a.obj", text.encode(), 1.0, None, said.append)
    return mesh.solid.volume, [diagnostic.code for diagnostic in said]


def test_a_box_with_seams_is_closed() -> None:
    volume, said = _read(textured(CUBE, SQUARES))
    assert (volume, said) == (pytest.approx(0.1 * 0.2 * 0.3, rel=1e-12), [])


def test_a_box_without_a_side_has_a_hole() -> None:
    volume, said = _read(textured(CUBE, SQUARES[1:]))
    assert (volume, said) == (pytest.approx(0.1 * 0.2 * 0.3, rel=1e-12), ["mesh-not-watertight"])


def test_a_globe_with_seams_and_poles_is_closed() -> None:
    volume, said = _read(textured(*_globe()))
    assert (volume, said) == (pytest.approx(_globe_volume(), rel=1e-9), [])


def test_a_notch_keeps_its_volume() -> None:
    """Its convex hull, as which a mesh with holes weighs, is a sixth larger."""
    outline = np.array([(0, 0), (2, 0), (2, 1), (1, 1), (1, 2), (0, 2)]) * 0.05
    count = len(outline)
    corners = np.array([(x, y, z) for z in (0.0, 0.1) for x, y in outline])
    sides = [(i, (i + 1) % count, count + (i + 1) % count, count + i) for i in range(count)]
    ends = [(0, 3, 2, 1), (0, 5, 4, 3), (6, 7, 8, 9), (6, 9, 10, 11)]
    volume, said = _read(textured(corners, [*sides, *ends]))
    assert (volume, said) == (pytest.approx(3 * 0.05**2 * 0.1, rel=1e-12), [])
