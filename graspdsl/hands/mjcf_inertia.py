"""Masses and inertias in MJCF about their principal axes."""

from __future__ import annotations

import numpy as np
from scipy.spatial.transform import Rotation

from graspdsl.arrays import Array
from graspdsl.hands.mjcf_parts import ORIENTATIONS, Part

ROUNDING = 1e-6  # of the largest moment: files have few digits


def principal(inertial: Part, moves: bool) -> tuple[float, Array, Rotation]:
    """The mass [kg], principal moments (3,) [kg m²] and the turn of their axes from the frame of the inertia.

    Raises DiagnosticError for what no body has: a mass or a moment that is not positive (zero is allowed where the body
    is fixed to its parent), or a moment larger than the sum of the others.
    """
    if "mass" not in inertial.attributes:
        raise inertial.refused("it has no mass", "give it one, in kg")
    mass = inertial.number("mass", "")
    moments, axes = _moments(inertial)
    least = min(mass, moments.min())
    if least < 0.0 or (moves and least == 0.0):
        raise inertial.refused("the mass and the moments of inertia of a body that moves are positive", None)
    if 2.0 * moments.max() > (1.0 + ROUNDING) * moments.sum():
        raise inertial.refused("one moment of inertia is larger than the others together: no body is so", None)
    return mass, moments, axes


def _moments(inertial: Part) -> tuple[Array, Rotation]:
    given = [key for key in ("diaginertia", "fullinertia") if key in inertial.attributes]
    if len(given) != 1:
        raise inertial.refused(f"it has {len(given)} inertias", "give it either diaginertia or fullinertia")
    if given == ["diaginertia"]:
        return inertial.numbers("diaginertia", "", 3), Rotation.identity()
    if any(key in inertial.attributes for key in ORIENTATIONS):
        raise inertial.refused("it has a fullinertia and is turned", "turn the inertia, or give diaginertia")
    xx, yy, zz, xy, xz, yz = inertial.numbers("fullinertia", "", 6)
    values, axes = np.linalg.eigh([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
    return values, Rotation.from_matrix(axes * np.sign(np.linalg.det(axes)))
