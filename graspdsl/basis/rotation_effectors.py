"""Effector transforms τ of the residuals by a rotation of the object that the contacts hold (Eq. 4.38, 4.39).

Held, the object and all contacts that touch it are one rigid body (Sec. 4.4.2): the contacts of Γτ cannot turn without
"the entire object along with" them, nor apart from each other. So r_1 = … = r_|Γτ| = r, three coordinates whichever
contacts are named, and a small turn δr about the point c that moments are taken about turns all of Γσ:

    lever a_j = x_j − c    → a_j + δr × a_j    of each contact of Γσ, and of the centre of mass, at which γ_g acts
    normal n_j             → n_j + δr × n_j    of each contact of Γσ; that of γ_g stays down

With w_j the weights in Γσ, g for γ_g and sums over the contacts of Γσ without it, the product rule gives

    ∂f/∂r = −[Σ w_j n_j]×                                           where ρ_f = Σ w_j n_j + w_g n_g
    ∂m/∂r = −[Σ w_j a_j × n_j]× + w_g [n_g]× [a_g]×                 where ρ_m = Σ w_j a_j × n_j + w_g a_g × n_g

These are what the chapter's ∂f/∂ψ ∂ψ/∂r comes to when ψ are the angles of the normals: turning a contact by δr moves
its ψ by just what turns its normal by δr × n, so that the choice of surface coordinates cancels, their poles too. The
tangent plane of Eq. 4.7, along which a contact slides and its normal stays, has no part in it: nothing slides.

Down the gradients 2 (∂f/∂r)ᵀ ρ_f and 2 (∂m/∂r)ᵀ ρ_m the residuals of the real object fall. Without γ_g these are
2 ρ_f × ρ_f = 0 and 2 ρ_m × ρ_m = 0, as the chapter has it under Eq. 4.41. With it the first is 2 w_g Σ w_j n_j × n_g:
zero, and ε_fr least, when the net of the contacts presses straight up against the weight.
"""

from __future__ import annotations

import numpy as np

from graspdsl.arrays import Array
from graspdsl.basis.algebra import skew
from graspdsl.basis.effector import Effector
from graspdsl.basis.spaces import GradientSpace


class ForceResidualRotation(Effector):
    """τ_frr = ∂f/∂r (Eq. 4.38): the normals of all contacts turn with the object, −[Σ w n]×, (..., 3, 3) [1/rad]."""

    symbol = "τ_frr"
    about = "net unit force by rotation of the held object with its contacts"
    equation = "4.38"
    gradient_space = GradientSpace.ROTATION
    reads = ("normals",)

    def evaluate(self, mixing: Array, *inputs: Array) -> Array:
        """−[Σ w n]× over the normals that turn, shape (..., 3, 3)."""
        (normals,) = inputs
        _, turning = mixing
        return -skew(turning @ normals)


class MomentResidualRotation(Effector):
    """τ_mrr = ∂m/∂r (Eq. 4.39): levers and normals of all contacts turn with the object, and the lever of gravity,
    −[Σ w (x − c) × n]× + w_g [n_g]× [x_g − c]×, (..., 3, 3) [m/rad]."""

    symbol = "τ_mrr"
    about = "net moment by rotation of the held object with its contacts"
    equation = "4.39"
    gradient_space = GradientSpace.ROTATION
    reads = ("points", "normals", "origin")

    def evaluate(self, mixing: Array, *inputs: Array) -> Array:
        """Σ w [n]× [x − c]× over the points that turn less Σ w [x − c]× [n]× over the normals, shape (..., 3, 3)."""
        points, normals, origin = inputs
        levers, across = skew(points - origin[..., None, :]), skew(normals)
        by_lever, by_normal = across @ levers, levers @ across
        carried, turning = mixing
        return np.asarray(
            np.einsum("k,...kij->...ij", carried, by_lever) - np.einsum("k,...kij->...ij", turning, by_normal)
        )
