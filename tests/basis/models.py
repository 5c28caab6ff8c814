"""What each effector transform takes the world for, written out as a motion.

A model is given a displacement in the effector's gradient space and says what the contacts then sense. An effector
transform is right when it is the derivative of its sensor transform along that motion.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

from graspdsl.arrays import Array
from graspdsl.contracts.drawing import CONTACTS

from .coordinates import Coordinates

Inputs = Mapping[str, Array]
Motion = Callable[[Inputs, Array, Coordinates], Inputs]


@dataclass(frozen=True)
class Part:
    """Rows of a task space that rest on one motion: the sensor of theirs, and what its reading is divided by."""

    sensor: str
    moved: Motion
    unit: str | None = None


@dataclass(frozen=True)
class Model:
    """The sensor an effector is the derivative of, and how each part of its rows comes to be sensed."""

    sensor: str
    parts: tuple[Part, ...]


def _model(sensor: str, moved: Motion) -> Model:
    return Model(sensor, (Part(sensor, moved),))


def _frames(inputs: Inputs, coordinates: Coordinates) -> Array:
    return coordinates.frames(inputs["normals"])


def _round_a_sphere(inputs: Inputs, psi: Array, coordinates: Coordinates) -> Inputs:
    """Contacts moved by ψ (2k,) over a sphere: inward normals turn against the motion."""
    return {**inputs, "normals": coordinates.turned(inputs["normals"], psi.reshape(-1, 2))}


def _on_a_plane(inputs: Inputs, psi: Array, coordinates: Coordinates) -> Inputs:
    """Contacts moved by r ψ (2k,) on their tangent planes: normals stay as they are."""
    step = np.einsum("kij,kj->ki", _frames(inputs, coordinates), psi.reshape(-1, 2))
    return {**inputs, "points": inputs["points"] + inputs["curvature_radius"] * step}


def _displaced(motion: Motion) -> Motion:
    """The motion of a displacement x (3k,) of the contacts: ψ is its part along the surface, over r (Eq. 4.27)."""

    def moved(inputs: Inputs, x: Array, coordinates: Coordinates) -> Inputs:
        along = np.einsum("kij,ki->kj", _frames(inputs, coordinates), x.reshape(-1, 3))
        return motion(inputs, along.ravel() / inputs["curvature_radius"], coordinates)

    return moved


def _over_the_surface(inputs: Inputs, x: Array, _: Coordinates) -> Inputs:
    """Contacts displaced by x (3k,) as far as that is along the surface, whose shape operators turn each normal about
    an axis in the tangent plane; the point that moments are taken about is carried along by its shares."""
    normals = inputs["normals"]
    step = x.reshape(-1, 3) - np.sum(x.reshape(-1, 3) * normals, axis=-1, keepdims=True) * normals
    change = -np.einsum("kij,kj->ki", inputs["shape_operators"], step)
    return {
        **inputs,
        "points": inputs["points"] + step,
        "normals": Rotation.from_rotvec(np.cross(normals, change)).apply(normals),
        "origin": inputs["origin"] + inputs["origin_shares"] @ step,
    }


def _turned(inputs: Inputs, r: Array, _: Coordinates) -> Inputs:
    """The object turns by r (3,) about the origin of moments, and all that is fixed to it: every contact with its
    normal, and the centre of mass, which stands behind the contacts where gravity is sensed. Down stays down."""
    turn, origin, normals = Rotation.from_rotvec(r), inputs["origin"], inputs["normals"].copy()
    normals[:CONTACTS] = turn.apply(normals[:CONTACTS])
    return {**inputs, "points": origin + turn.apply(inputs["points"] - origin), "normals": normals}


def _joints_move(inputs: Inputs, angles: Array, _: Coordinates) -> Inputs:
    """Contact points follow the joints through their Jacobians."""
    return {**inputs, "points": inputs["points"] + inputs["jacobian"] @ angles}


def _joints_turn(inputs: Inputs, angles: Array, _: Coordinates) -> Inputs:
    """Contacts turn about fixed axes through their angular Jacobians; what is read is how far from where they were."""
    before = Rotation.from_rotvec(inputs["orientations"])
    after = Rotation.from_rotvec(inputs["angular_jacobian"] @ angles) * before
    return {**inputs, "orientations": (after * before.inv()).as_rotvec()}


def _joints_press(inputs: Inputs, angles: Array, _: Coordinates) -> Inputs:
    """Contacts follow the joints; each answers a metre along its normal with a newton along it, at a fixed lever."""
    motion = inputs["jacobian"] @ angles
    depth = np.sum(motion * inputs["normals"], axis=-1, keepdims=True)
    return {**inputs, "forces": inputs["forces"] + depth * inputs["normals"]}


def _joints_alone(inputs: Inputs, angles: Array, _: Coordinates) -> Inputs:
    """The joints move, in scaled coordinates."""
    return {**inputs, "joints": inputs["joints"] + inputs["joint_weights"] * angles}


MODELS: Mapping[str, Model] = {
    "τ_fr": _model("σ_fr", _round_a_sphere),
    "τ_mr": _model("σ_mr", _on_a_plane),
    "τ_w": Model("σ_w", (Part("σ_fr", _round_a_sphere), Part("σ_mr", _on_a_plane, "curvature_radius"))),
    "τ_frx": _model("σ_fr", _displaced(_round_a_sphere)),
    "τ_mrx": _model("σ_mr", _displaced(_on_a_plane)),
    "τ_wx": Model(
        "σ_w",
        (Part("σ_fr", _displaced(_round_a_sphere)), Part("σ_mr", _displaced(_on_a_plane), "curvature_radius")),
    ),
    "τ_wsx": Model("σ_w", (Part("σ_fr", _over_the_surface), Part("σ_mr", _over_the_surface, "curvature_radius"))),
    "τ_frr": _model("σ_fr", _turned),
    "τ_mrr": _model("σ_mr", _turned),
    "τ_p": _model("σ_p", _joints_move),
    "τ_r": _model("σ_r", _joints_turn),
    "τ_f": _model("σ_f", _joints_press),
    "τ_m": _model("σ_m", _joints_press),
    "τ_k": _model("σ_k", _joints_alone),
}
