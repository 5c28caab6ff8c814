"""Effector transforms τ: Jacobians of what is sensed with respect to what is moved (Eq. 3.5, 4.33)."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping
from typing import ClassVar

import numpy as np

from graspdsl.arrays import Array
from graspdsl.basis.algebra import in_columns, in_rows, skew, tangent_frames, tangent_projectors
from graspdsl.basis.spaces import GradientSpace


class Effector(ABC):
    """An effector transform: ``reads`` names its inputs, fields of an Observation or ``curvature_radius`` [m], that of
    the sphere which the force residual takes the surface for.

    On the surface the k contacts move by (2k,) coordinates, in Cartesian space by a (3k,) displacement; in joint space
    the n joints do.
    """

    symbol: ClassVar[str]
    about: ClassVar[str]
    equation: ClassVar[str]
    gradient_space: ClassVar[GradientSpace]
    reads: ClassVar[tuple[str, ...]]

    @abstractmethod
    def evaluate(self, mixing: Array, *inputs: Array) -> Array:
        """τ, (..., d, D): rows of the task space, columns of the gradient space.

        mixing: (m, k) in joint space, weights (k,) otherwise.
        """


class ForceResidualSurface(Effector):
    """τ_fr = ∂f/∂ψ (Eq. 4.12): on the unit sphere, ∂f_i/∂ψ_i = −w_i (t₁ t₂)_i, (..., 3, 2k) [1/rad].

    ψ are coordinates along a local tangent frame (t₁ t₂) at each contact.
    """

    symbol = "τ_fr"
    about = "net unit force by surface coordinates, surface taken for a sphere"
    equation = "4.12"
    gradient_space = GradientSpace.SURFACE
    reads = ("normals",)

    def evaluate(self, mixing: Array, *inputs: Array) -> Array:
        """−w (t₁ t₂) side by side, shape (..., 3, 2k)."""
        (normals,) = inputs
        return in_columns(tangent_frames(normals) * -mixing[:, None, None])


class MomentResidualSurface(Effector):
    """τ_mr = ∂m/∂ψ (Eq. 4.16): on a plane, with r_θ = rθ, ∂m_i/∂ψ_i = −w_i r [n_i]× (t₁ t₂)_i, (..., 3, 2k) [m/rad]."""

    symbol = "τ_mr"
    about = "net moment by surface coordinates, surface taken for a plane"
    equation = "4.16"
    gradient_space = GradientSpace.SURFACE
    reads = ("normals", "curvature_radius")

    def evaluate(self, mixing: Array, *inputs: Array) -> Array:
        """−w r [n]× (t₁ t₂) side by side, shape (..., 3, 2k)."""
        normals, curvature_radius = inputs
        return in_columns(skew(normals) @ tangent_frames(normals) * (-mixing * curvature_radius)[:, None, None])


class ForceResidualDisplacement(Effector):
    """τ_frx = ∂f/∂ψ (r̂_θ r̂_φ)ᵀ (Eq. 4.28): on a sphere of radius r, ∂f_i/∂x_i = −w_i P_i / r, (..., 3, 3k) [1/m].

    P = I − n nᵀ makes it free of the choice of surface coordinates and of their poles.
    """

    symbol = "τ_frx"
    about = "net unit force by contact displacements, surface taken for a sphere"
    equation = "4.28"
    gradient_space = GradientSpace.CARTESIAN
    reads = ("normals", "curvature_radius")

    def evaluate(self, mixing: Array, *inputs: Array) -> Array:
        """−w P / r side by side, shape (..., 3, 3k)."""
        normals, curvature_radius = inputs
        return in_columns(tangent_projectors(normals) * (-mixing / curvature_radius)[:, None, None])


class MomentResidualDisplacement(Effector):
    """τ_mrx = ∂m/∂ψ (r̂_θ r̂_φ)ᵀ (Eq. 4.29): on a plane, ∂m_i/∂x_i = −w_i [n_i]× P_i, (..., 3, 3k) [1].

    n is normal to the plane, so [n]× already leaves its own direction out.
    """

    symbol = "τ_mrx"
    about = "net moment by contact displacements, surface taken for a plane"
    equation = "4.29"
    gradient_space = GradientSpace.CARTESIAN
    reads = ("normals",)

    def evaluate(self, mixing: Array, *inputs: Array) -> Array:
        """−w [n]× side by side, shape (..., 3, 3k)."""
        (normals,) = inputs
        return in_columns(skew(normals) * -mixing[:, None, None])


class PositionJacobian(Effector):
    """τ_p = ∂x/∂q, the Jacobians of the contact points (Eq. 4.20; means by 4.34), (..., 3m, n) [m/m or m/rad]."""

    symbol = "τ_p"
    about = "contact positions by joint displacements"
    equation = "4.20"
    gradient_space = GradientSpace.JOINTS
    reads = ("jacobian",)

    def evaluate(self, mixing: Array, *inputs: Array) -> Array:
        """R J stacked, shape (..., 3m, n)."""
        (jacobian,) = inputs
        return in_rows(np.einsum("rk,...kij->...rij", mixing, jacobian))


class ForceJacobian(Effector):
    """τ_f = n nᵀ ∂x/∂q, motion into the surface, which a contact of unit stiffness answers with a force along its
    normal (Eq. 4.21; means by 4.34), (..., 3m, n) [N/m of stiffness]."""

    symbol = "τ_f"
    about = "contact forces by joint displacements, for unit stiffness"
    equation = "4.21"
    gradient_space = GradientSpace.JOINTS
    reads = ("jacobian", "normals")

    def evaluate(self, mixing: Array, *inputs: Array) -> Array:
        """R (n nᵀ J) stacked, shape (..., 3m, n)."""
        jacobian, normals = inputs
        pressing = normals[..., :, None] * np.einsum("...ki,...kij->...kj", normals, jacobian)[..., None, :]
        return in_rows(np.einsum("rk,...kij->...rij", mixing, pressing))


EFFECTORS: Mapping[str, Effector] = {
    effector.symbol: effector
    for effector in (
        ForceResidualSurface(),
        ForceResidualDisplacement(),
        MomentResidualSurface(),
        MomentResidualDisplacement(),
        PositionJacobian(),
        ForceJacobian(),
    )
}
