"""What each effector transform takes the world for, written out as a motion.

A model is given a displacement in the effector's gradient space and says what the contacts then sense. An effector
transform is right when it is the derivative of its sensor transform along that motion.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from graspdsl.arrays import Array
from graspdsl.basis.algebra import tangent_frames

Inputs = Mapping[str, Array]


@dataclass(frozen=True)
class Model:
    """The sensor an effector is the derivative of, and what the sensor reads once the displacement is made."""

    sensor: str
    moved: Callable[[Inputs, Array], Inputs]


def _over_the_surface(inputs: Inputs, coordinates: Array) -> Array:
    """ψ (2k,), in each contact's tangent frame, as directions in space (k, 3)."""
    return np.einsum("kij,kj->ki", tangent_frames(inputs["normals"]), coordinates.reshape(-1, 2))


def _along_the_tangent(inputs: Inputs, displacement: Array) -> Array:
    """The parts (k, 3) of contact displacements (3k,) along the surface."""
    steps, normals = displacement.reshape(-1, 3), inputs["normals"]
    return steps - np.sum(steps * normals, axis=-1, keepdims=True) * normals


def _round_a_sphere(inputs: Inputs, arc: Array) -> Inputs:
    """Contacts moved by an arc (k, 3) over a unit sphere: inward normals turn against the motion."""
    turned = inputs["normals"] - arc
    return {**inputs, "normals": turned / np.linalg.norm(turned, axis=-1, keepdims=True)}


def _on_a_plane(inputs: Inputs, step: Array) -> Inputs:
    """Contacts moved by (k, 3) on their tangent planes: normals stay as they are."""
    return {**inputs, "points": inputs["points"] + step}


def _joints_move(inputs: Inputs, angles: Array) -> Inputs:
    """Contact points follow the joints through their Jacobians."""
    return {**inputs, "points": inputs["points"] + inputs["jacobian"] @ angles}


def _joints_press(inputs: Inputs, angles: Array) -> Inputs:
    """Contacts follow the joints; each answers a metre along its normal with a newton along it."""
    motion = inputs["jacobian"] @ angles
    depth = np.sum(motion * inputs["normals"], axis=-1, keepdims=True)
    return {**inputs, "forces": inputs["forces"] + depth * inputs["normals"]}


MODELS: Mapping[str, Model] = {
    "τ_fr": Model("σ_fr", lambda inputs, psi: _round_a_sphere(inputs, _over_the_surface(inputs, psi))),
    "τ_mr": Model(
        "σ_mr",
        lambda inputs, psi: _on_a_plane(inputs, inputs["curvature_radius"] * _over_the_surface(inputs, psi)),
    ),
    "τ_frx": Model(
        "σ_fr",
        lambda inputs, x: _round_a_sphere(inputs, _along_the_tangent(inputs, x) / inputs["curvature_radius"]),
    ),
    "τ_mrx": Model("σ_mr", lambda inputs, x: _on_a_plane(inputs, _along_the_tangent(inputs, x))),
    "τ_p": Model("σ_p", _joints_move),
    "τ_f": Model("σ_f", _joints_press),
}
