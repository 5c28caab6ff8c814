"""Random contacts, the same for each run."""

from __future__ import annotations

import numpy as np

from graspdsl.arrays import Array

from .coordinates import TANGENT, Coordinates

JOINTS = 5


def generator() -> np.random.Generator:
    """A fresh generator of random numbers."""
    return np.random.default_rng(7)


def unit_vectors(random: np.random.Generator, *shape: int) -> Array:
    """Directions spread evenly over the sphere, (*shape, 3)."""
    vectors = random.normal(size=(*shape, 3))
    unit: Array = vectors / np.linalg.norm(vectors, axis=-1, keepdims=True)
    return unit


def with_gravity(given: dict[str, Array], random: np.random.Generator) -> dict[str, Array]:
    """Inputs with gravity behind the contacts: at the centre of mass, its force the weight, its normal down."""
    shape = (*given["points"].shape[:-2], 1, 3)
    down = np.broadcast_to([0.0, 0.0, -1.0], shape)
    behind = {"points": random.normal(size=shape), "forces": random.uniform(0.1, 9.0) * down, "normals": down}
    return {**given, **{name: np.concatenate([given[name], row], axis=-2) for name, row in behind.items()}}


def inputs(
    random: np.random.Generator, contacts: int, *batch: int, coordinates: Coordinates = TANGENT
) -> dict[str, Array]:
    """Everything that a sensor or effector transform may read, for contacts on a hand with JOINTS joints."""
    drawn = {
        "points": random.normal(size=(*batch, contacts, 3)),
        "normals": unit_vectors(random, *batch, contacts),
        "forces": random.normal(size=(*batch, contacts, 3)),
        "jacobian": random.normal(size=(*batch, contacts, 3, JOINTS)),
        "angular_jacobian": random.normal(size=(*batch, contacts, 3, JOINTS)),
        "orientations": random.normal(size=(*batch, contacts, 3)),
        "joints": random.normal(size=(*batch, JOINTS)),
        "joint_weights": random.uniform(0.5, 10.0, size=JOINTS),
        "origin": random.normal(size=(*batch, 3)),
        "curvature_radius": np.array(0.37),
    }
    return {
        **drawn,
        "frames": coordinates.frames(drawn["normals"]),
        "stretch": coordinates.stretch(drawn["normals"]),
    }
