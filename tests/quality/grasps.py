"""Sets of contacts whose quality is known in closed form, and random ones."""

from __future__ import annotations

import math

import numpy as np
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from graspdsl.arrays import Array
from graspdsl.quality.contact_models import FrictionlessPoint
from graspdsl.quality.wrench_space import WrenchSpace

Contacts = tuple[Array, Array]


def antipodal(radius: float = 0.05, turned: float = 0.0) -> Contacts:
    """Two contacts on the x axis that face each other, both normals turned by the same angle [rad] about z and -z."""
    points = radius * np.array([[-1.0, 0.0, 0.0], [1.0, 0.0, 0.0]])
    normals = np.array([[math.cos(turned), math.sin(turned), 0.0], [-math.cos(turned), math.sin(turned), 0.0]])
    return points, normals


def coupled(turned: float, radius: float = 0.05) -> Contacts:
    """Two contacts on the x axis whose normals are opposite and both turned by an angle [rad] about z."""
    points, _ = antipodal(radius)
    normal = np.array([math.cos(turned), math.sin(turned), 0.0])
    return points, np.array([normal, -normal])


def ring(count: int = 3, radius: float = 0.05) -> Contacts:
    """Contacts evenly around a circle in the xy plane, normals towards its centre."""
    angles = 2.0 * math.pi * np.arange(count) / count
    outward = np.column_stack([np.cos(angles), np.sin(angles), np.zeros(count)])
    return radius * outward, -outward


def one_sided() -> Contacts:
    """Three contacts that all push down."""
    points, _ = ring()
    return points, np.tile([0.0, 0.0, -1.0], (3, 1))


def raw(wrenches: Array) -> WrenchSpace:
    """A space of these primitive wrenches (m, 6), as if each were what a contact pushes with."""
    basis = np.stack([wrenches, *[np.zeros_like(wrenches)] * 3], axis=1)
    return WrenchSpace(basis, FrictionlessPoint(), np.zeros(3), 1.0)


def random_contacts(seed: int, count: int) -> Contacts:
    """Contacts anywhere on an ellipsoid, normals into it."""
    random = np.random.default_rng(seed)
    on_ball = random.normal(size=(count, 3))
    on_ball /= np.linalg.norm(on_ball, axis=1)[:, None]
    axes = np.array([0.04, 0.06, 0.09])
    normals = -on_ball / axes
    return on_ball * axes, normals / np.linalg.norm(normals, axis=1)[:, None]


rotations = st.integers(0, 2**32 - 1).map(lambda seed: Rotation.random(random_state=seed).as_matrix())
