"""What an effector transform takes the world for: how what is read changes when something moves a little."""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np

from graspdsl.arrays import Array
from graspdsl.basis.algebra import along
from graspdsl.basis.rotations import exponential
from graspdsl.basis.spaces import GradientSpace
from graspdsl.contracts.drawing import CONTACTS, JOINTS, Inputs

Motion = Callable[[Inputs, Array], Inputs]


def _along_planes(given: Inputs, psi: Array) -> Inputs:
    """Contacts slide by r T ψ; normals stay."""
    step = given["curvature_radius"] * np.einsum("kij,kj->ki", given["frames"], psi.reshape(-1, 2))
    return {**given, "points": given["points"] + step}


def _over_spheres(given: Inputs, psi: Array) -> Inputs:
    """And inward normals turn against the motion, by −T S ψ."""
    turned = np.einsum("kij,kj,kj->ki", given["frames"], given["stretch"], psi.reshape(-1, 2))
    normals = given["normals"] - turned
    return {**_along_planes(given, psi), "normals": normals / np.linalg.norm(normals, axis=-1, keepdims=True)}


def _displaced(motion: Motion) -> Motion:
    """The motion of a displacement x: ψ is its part along the surface, over r (Eq. 4.27)."""

    def moved(given: Inputs, x: Array) -> Inputs:
        along = np.einsum("kij,ki->kj", given["frames"], x.reshape(-1, 3))
        return motion(given, along.ravel() / given["curvature_radius"])

    return moved


def _over_the_surface(given: Inputs, x: Array) -> Inputs:
    """Contacts slide by what of x is along the surface; its shape operators turn the normals, the origin goes along."""
    inward = given["normals"][:CONTACTS]
    step = x.reshape(-1, 3) - along(x.reshape(-1, 3), inward)
    normals = inward - np.einsum("kij,kj->ki", given["shape_operators"], step)
    return {
        **given,
        "points": given["points"] + step,
        "normals": normals / np.linalg.norm(normals, axis=-1, keepdims=True),
        "origin": given["origin"] + given["origin_shares"] @ step,
    }


def _turned(given: Inputs, r: Array) -> Inputs:
    """The object turns about the origin of moments with all that is fixed to it; down stays down."""
    turn, origin = exponential(r), given["origin"]
    after = {name: given[name].copy() for name in ("normals", "forces")}
    for value in after.values():
        value[:CONTACTS] = value[:CONTACTS] @ turn.T
    for name in ("points", "centre_of_mass"):
        after[name] = origin + (given[name] - origin) @ turn.T
    return {**given, **after, "orientations": np.tile(r, (CONTACTS, 1))}


def _pressed(given: Inputs, q: Array) -> Inputs:
    """Contacts of unit stiffness answer what the joints press into the surface, where they are."""
    depth = np.sum((given["jacobian"] @ q) * given["normals"], axis=-1, keepdims=True)
    return {**given, "forces": given["forces"] + depth * given["normals"]}


def _driven(given: Inputs, q: Array) -> Inputs:
    """Contacts go with the joints and turn, and press; orientations are read from where they were."""
    return {
        **_pressed(given, q),
        "points": given["points"] + given["jacobian"] @ q,
        "orientations": given["angular_jacobian"] @ q,
        "joints": given["joints"] + given["joint_weights"] * q,
    }


# By gradient space: the motions of which an effector transform may be the derivative, in words.
MOTIONS: Mapping[GradientSpace, Mapping[str, Motion]] = {
    GradientSpace.SURFACE: {
        "contacts slide over a sphere": _over_spheres,
        "contacts slide along their tangent planes": _along_planes,
    },
    GradientSpace.CARTESIAN: {
        "contacts slide over a sphere": _displaced(_over_spheres),
        "contacts slide along their tangent planes": _displaced(_along_planes),
        "contacts slide over the surface as it is curved": _over_the_surface,
    },
    GradientSpace.ROTATION: {"the object turns with its contacts": _turned},
    GradientSpace.JOINTS: {
        "the joints move the contacts": _driven,
        "the joints press the contacts, at fixed levers": _pressed,
    },
}
COLUMNS: Mapping[GradientSpace, int] = {
    GradientSpace.SURFACE: 2 * CONTACTS,
    GradientSpace.CARTESIAN: 3 * CONTACTS,
    GradientSpace.ROTATION: 3,
    GradientSpace.JOINTS: JOINTS,
}
