"""Coordinates ψ on the model sphere, and where they take a contact."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from graspdsl.arrays import Array
from graspdsl.basis.algebra import tangent_frames
from graspdsl.contracts import drawing


@dataclass(frozen=True)
class Coordinates(drawing.Coordinates):
    """``turned`` says where the inward normals (k, 3) of contacts on a sphere point after a displacement ψ (k, 2),
    without frames and stretch."""

    turned: Callable[[Array, Array], Array]


def force(theta: Array, phi: Array) -> Array:
    """Eq. 4.3, of (θ, φ): (..., 3)."""
    return -np.stack([np.cos(theta) * np.cos(phi), np.sin(theta) * np.cos(phi), np.sin(phi)], axis=-1)


def angles(normals: Array) -> tuple[Array, Array]:
    """θ and φ of inward normals (..., 3), the inverse of Eq. 4.3."""
    return np.arctan2(-normals[..., 1], -normals[..., 0]), np.arcsin(-normals[..., 2])


def _along_the_frame(normals: Array, psi: Array) -> Array:
    """Against the motion along the two axes of the tangent frame, on the unit sphere."""
    turned = normals - np.einsum("kij,kj->ki", tangent_frames(normals), psi)
    unit: Array = turned / np.linalg.norm(turned, axis=-1, keepdims=True)
    return unit


def _by_angles(normals: Array, psi: Array) -> Array:
    """To θ + ψ₁ and φ + ψ₂."""
    theta, phi = angles(normals)
    return force(theta + psi[:, 0], phi + psi[:, 1])


TANGENT = Coordinates(drawing.TANGENT.name, drawing.TANGENT.frames, drawing.TANGENT.stretch, _along_the_frame)
SPHERICAL = Coordinates(drawing.SPHERICAL.name, drawing.SPHERICAL.frames, drawing.SPHERICAL.stretch, _by_angles)
COORDINATES = (TANGENT, SPHERICAL)
