"""Random contacts, the same for each run."""

from __future__ import annotations

import numpy as np

from graspdsl.arrays import Array

JOINTS = 5


def generator() -> np.random.Generator:
    """A fresh generator of random numbers."""
    return np.random.default_rng(7)


def unit_vectors(random: np.random.Generator, *shape: int) -> Array:
    """Directions spread evenly over the sphere, (*shape, 3)."""
    vectors = random.normal(size=(*shape, 3))
    unit: Array = vectors / np.linalg.norm(vectors, axis=-1, keepdims=True)
    return unit


def inputs(random: np.random.Generator, contacts: int, *batch: int) -> dict[str, Array]:
    """Everything that a sensor or effector transform may read, for contacts on a hand with JOINTS joints."""
    return {
        "points": random.normal(size=(*batch, contacts, 3)),
        "normals": unit_vectors(random, *batch, contacts),
        "forces": random.normal(size=(*batch, contacts, 3)),
        "jacobian": random.normal(size=(*batch, contacts, 3, JOINTS)),
        "origin": random.normal(size=(*batch, 3)),
        "curvature_radius": np.array(0.37),
    }
