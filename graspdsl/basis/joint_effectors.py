"""Effector transforms τ into joint space: Jacobians with respect to the joints of hand and mount."""

from __future__ import annotations

import numpy as np

from graspdsl.arrays import Array
from graspdsl.basis.algebra import in_rows, skew
from graspdsl.basis.effector import Effector
from graspdsl.basis.spaces import GradientSpace


class PositionJacobian(Effector):
    """τ_p = ∂x/∂q, the Jacobians of the contact points (Eq. 4.20; means by 4.34), (..., 3m, n) [m/rad]."""

    symbol = "τ_p"
    about = "contact positions by joint displacements"
    equation = "4.20"
    gradient_space = GradientSpace.JOINTS
    reads = ("jacobian",)

    def evaluate(self, mixing: Array, *inputs: Array) -> Array:
        """R J stacked, shape (..., 3m, n)."""
        (jacobian,) = inputs
        return in_rows(np.einsum("rk,...kij->...rij", mixing, jacobian))


class OrientationJacobian(Effector):
    """τ_r = ∂r/∂q, the angular Jacobians of the contacts (Eq. 4.41; means by 4.34), (..., 3m, n) [rad/rad]."""

    symbol = "τ_r"
    about = "contact orientations by joint displacements"
    equation = "4.41"
    gradient_space = GradientSpace.JOINTS
    reads = ("angular_jacobian",)

    def evaluate(self, mixing: Array, *inputs: Array) -> Array:
        """R J_ω stacked, shape (..., 3m, n)."""
        (jacobian,) = inputs
        return in_rows(np.einsum("rk,...kij->...rij", mixing, jacobian))


class ForceJacobian(Effector):
    """τ_f = n nᵀ ∂x/∂q, motion into the surface, which a contact of unit stiffness answers with a force along its
    normal (Eq. 4.21; means by 4.34), (..., 3m, n) [N/rad per N/m of stiffness]."""

    symbol = "τ_f"
    about = "contact forces by joint displacements, for unit stiffness"
    equation = "4.21"
    gradient_space = GradientSpace.JOINTS
    reads = ("jacobian", "normals")

    def evaluate(self, mixing: Array, *inputs: Array) -> Array:
        """R (n nᵀ J) stacked, shape (..., 3m, n)."""
        jacobian, normals = inputs
        return in_rows(np.einsum("rk,...kij->...rij", mixing, _pressing(jacobian, normals)))


class MomentJacobian(Effector):
    """τ_m = [x − c]× n nᵀ ∂x/∂q, the moment of the force that a contact of unit stiffness answers with, at a fixed
    lever (Sec. 3.1.2), (..., 3m, n) [N·m/rad per N/m of stiffness]."""

    symbol = "τ_m"
    about = "moments of contact forces by joint displacements, for unit stiffness"
    equation = "Sec. 3.1.2"
    gradient_space = GradientSpace.JOINTS
    reads = ("jacobian", "normals", "points", "origin")

    def evaluate(self, mixing: Array, *inputs: Array) -> Array:
        """R ([x − c]× n nᵀ J) stacked, shape (..., 3m, n)."""
        jacobian, normals, points, origin = inputs
        levers = skew(points - origin[..., None, :])
        return in_rows(np.einsum("rk,...kij->...rij", mixing, levers @ _pressing(jacobian, normals)))


class PostureSelection(Effector):
    """τ_k = ∂q_σ/∂q_τ: which of the joints in Γσ are moved by those in Γτ (Eq. 4.25), (..., s, n) [1]."""

    symbol = "τ_k"
    about = "joints of a set by joint displacements"
    equation = "4.25"
    gradient_space = GradientSpace.JOINTS
    reads = ("joint_weights",)

    def evaluate(self, mixing: Array, *inputs: Array) -> Array:
        """S with the columns of joints outside Γτ zero, in scaled joint coordinates, shape (s, n)."""
        (weights,) = inputs
        return np.asarray(mixing * weights)


def _pressing(jacobian: Array, normals: Array) -> Array:
    """n nᵀ J for each contact, (..., k, 3, n)."""
    pressed = normals[..., :, None] * np.einsum("...ki,...kij->...kj", normals, jacobian)[..., None, :]
    return np.asarray(pressed)
