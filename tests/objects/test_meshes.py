"""Meshes for drawing are closed, face outwards and stay on the surface."""

from __future__ import annotations

import numpy as np
import pytest

from graspdsl.objects.cylinder import RoundedCylinder
from graspdsl.objects.ellipsoid import SmoothEllipsoid
from graspdsl.objects.sphere import SmoothSphere
from graspdsl.objects.surfaces.mesh import Mesh
from graspdsl.objects.surfaces.surface import Surface

from .table import EACH_SURFACE

VOLUMES = {
    "sphere": (SmoothSphere(0.1), np.pi / 6 * 1e-3),
    "ellipsoid": (SmoothEllipsoid((0.05, 0.06, 0.08)), 4 / 3 * np.pi * 0.05 * 0.06 * 0.08),
    "capsule": (RoundedCylinder(0.1, 0.3, 0.05), np.pi / 6 * 1e-3 + np.pi * 0.05**2 * 0.2),
}


def _volume(mesh: Mesh) -> float:
    """The volume that the faces enclose, positive where they face outwards (divergence theorem)."""
    a, b, c = np.moveaxis(mesh.vertices[mesh.faces], 1, 0)
    return float(np.sum(a * np.cross(b, c)) / 6)


@EACH_SURFACE
def test_every_edge_is_met_by_a_face_from_either_side(surface: Surface) -> None:
    mesh = surface.mesh(12)
    edges = np.concatenate([mesh.faces[:, [0, 1]], mesh.faces[:, [1, 2]], mesh.faces[:, [2, 0]]])
    there = {(int(a), int(b)) for a, b in edges}
    assert len(there) == len(edges)
    assert there == {(b, a) for a, b in there}
    assert len(mesh.vertices) - len(edges) // 2 + len(mesh.faces) == 2
    assert set(mesh.faces.ravel()) == set(range(len(mesh.vertices)))


@EACH_SURFACE
def test_vertices_are_on_the_surface_and_faces_look_outwards(surface: Surface) -> None:
    mesh = surface.mesh(24)
    assert np.abs(surface.level(mesh.vertices)).max() < 1e-12 * surface.size
    a, b, c = np.moveaxis(mesh.vertices[mesh.faces], 1, 0)
    outward = surface.normals((a + b + c) / 3)
    assert np.all(np.sum(np.cross(b - a, c - a) * outward, axis=-1) > 0.0)


@pytest.mark.parametrize(("surface", "volume"), VOLUMES.values(), ids=VOLUMES)
def test_volume(surface: Surface, volume: float) -> None:
    assert _volume(surface.mesh(100)) == pytest.approx(volume, rel=1e-3)
