"""Effector transforms τ of the residuals: net unit force and moment by sliding contacts (Eq. 4.12 to 4.29).

They rest on two models of the surface at a contact: for the force, a sphere of curvature radius r; for the moment, the
tangent plane. ``frames`` T (..., k, 3, 2) span the tangent planes; ``stretch`` S (..., k, 2) is one for local tangent
frames and (cos φ, 1) for the chapter's spherical coordinates, which shrink towards their poles (Eq. 4.4).
"""

from __future__ import annotations

import numpy as np

from graspdsl.arrays import Array
from graspdsl.basis.algebra import in_columns, skew
from graspdsl.basis.effector import Effector
from graspdsl.basis.spaces import GradientSpace


def force_by_surface(weights: Array, frames: Array, stretch: Array) -> Array:
    """∂f_i/∂ψ_i = −w_i T S on the unit sphere, (..., k, 3, 2) [1/rad] (Eq. 4.4)."""
    return np.asarray(frames * stretch[..., None, :] * -weights[:, None, None])


def moment_by_surface(weights: Array, normals: Array, frames: Array, radius: Array) -> Array:
    """∂m_i/∂ψ_i = −w_i r [n_i]× T on the tangent plane, a displacement being r ψ, (..., k, 3, 2) [m/rad] (Eq. 4.7)."""
    return np.asarray(skew(normals) @ frames * (-weights * radius)[:, None, None])


def surface_by_cartesian(frames: Array, radius: Array) -> Array:
    """∂ψ/∂x = (r̂_θ r̂_φ)ᵀ / r, (..., k, 2, 3) [rad/m] (Eq. 4.27)."""
    return np.asarray(np.swapaxes(frames, -1, -2) / radius)


class ForceResidualSurface(Effector):
    """τ_fr = ∂f/∂ψ (Eq. 4.12): on the unit sphere, ∂f_i/∂ψ_i = −w_i T S, (..., 3, 2k) [1/rad]."""

    symbol = "τ_fr"
    about = "net unit force by surface coordinates, surface taken for a sphere"
    equation = "4.12"
    gradient_space = GradientSpace.SURFACE
    reads = ("frames", "stretch")

    def evaluate(self, mixing: Array, *inputs: Array) -> Array:
        """−w T S side by side, shape (..., 3, 2k)."""
        return in_columns(force_by_surface(mixing, *inputs))


class MomentResidualSurface(Effector):
    """τ_mr = ∂m/∂ψ (Eq. 4.16): on a plane, with r_θ = rθ, ∂m_i/∂ψ_i = −w_i r [n_i]× T, (..., 3, 2k) [m/rad]."""

    symbol = "τ_mr"
    about = "net moment by surface coordinates, surface taken for a plane"
    equation = "4.16"
    gradient_space = GradientSpace.SURFACE
    reads = ("normals", "frames", "curvature_radius")

    def evaluate(self, mixing: Array, *inputs: Array) -> Array:
        """−w r [n]× T side by side, shape (..., 3, 2k)."""
        return in_columns(moment_by_surface(mixing, *inputs))


class WrenchResidualSurface(Effector):
    """τ_w: τ_fr above τ_mr / r (Sec. 4.1.3), (..., 6, 2k) [1/rad]."""

    symbol = "τ_w"
    about = "net wrench by surface coordinates"
    equation = "Sec. 4.1.3"
    gradient_space = GradientSpace.SURFACE
    reads = ("normals", "frames", "stretch", "curvature_radius")

    def evaluate(self, mixing: Array, *inputs: Array) -> Array:
        """Force rows above moment rows, shape (..., 6, 2k)."""
        normals, frames, stretch, radius = inputs
        moment = moment_by_surface(mixing, normals, frames, radius) / radius
        return in_columns(np.concatenate([force_by_surface(mixing, frames, stretch), moment], axis=-2))


class ForceResidualDisplacement(Effector):
    """τ_frx = ∂f/∂ψ (r̂_θ r̂_φ)ᵀ (Eq. 4.28): on a sphere of radius r, ∂f_i/∂x_i = −w_i T S Tᵀ / r, (..., 3, 3k) [1/m].

    With local frames T Tᵀ = I − n nᵀ, free of the choice of surface coordinates and of their poles.
    """

    symbol = "τ_frx"
    about = "net unit force by contact displacements, surface taken for a sphere"
    equation = "4.28"
    gradient_space = GradientSpace.CARTESIAN
    reads = ("frames", "stretch", "curvature_radius")

    def evaluate(self, mixing: Array, *inputs: Array) -> Array:
        """−w T S Tᵀ / r side by side, shape (..., 3, 3k)."""
        frames, stretch, radius = inputs
        return in_columns(force_by_surface(mixing, frames, stretch) @ surface_by_cartesian(frames, radius))


class MomentResidualDisplacement(Effector):
    """τ_mrx = ∂m/∂ψ (r̂_θ r̂_φ)ᵀ (Eq. 4.29): on a plane, ∂m_i/∂x_i = −w_i [n_i]× T Tᵀ, (..., 3, 3k) [1]."""

    symbol = "τ_mrx"
    about = "net moment by contact displacements, surface taken for a plane"
    equation = "4.29"
    gradient_space = GradientSpace.CARTESIAN
    reads = ("normals", "frames", "curvature_radius")

    def evaluate(self, mixing: Array, *inputs: Array) -> Array:
        """−w [n]× T Tᵀ side by side, shape (..., 3, 3k)."""
        normals, frames, radius = inputs
        moved = moment_by_surface(mixing, normals, frames, radius) @ surface_by_cartesian(frames, radius)
        return in_columns(moved)


class WrenchResidualDisplacement(Effector):
    """τ_wx: τ_frx above τ_mrx / r (Sec. 4.1.3), (..., 6, 3k) [1/m]."""

    symbol = "τ_wx"
    about = "net wrench by contact displacements"
    equation = "Sec. 4.1.3"
    gradient_space = GradientSpace.CARTESIAN
    reads = ("normals", "frames", "stretch", "curvature_radius")

    def evaluate(self, mixing: Array, *inputs: Array) -> Array:
        """Force rows above moment rows, shape (..., 6, 3k)."""
        normals, frames, stretch, radius = inputs
        moment = moment_by_surface(mixing, normals, frames, radius) / radius
        both = np.concatenate([force_by_surface(mixing, frames, stretch), moment], axis=-2)
        return in_columns(both @ surface_by_cartesian(frames, radius))
