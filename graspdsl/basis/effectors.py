"""Effector transforms τ: the Jacobian of what is sensed with respect to what is moved (Eq. 3.5, 4.33).

Those of the residuals by sliding contacts (Eq. 4.12 to 4.29) rest on two models of the surface at a contact: for the
force, a sphere of curvature radius r; for the moment, the tangent plane. ``frames`` T (..., k, 3, 2) span the tangent
planes; ``stretch`` S (..., k, 2) is one for local tangent frames and (cos φ, 1) for the chapter's spherical
coordinates, which shrink towards their poles (Eq. 4.4).
"""

from __future__ import annotations

from abc import abstractmethod
from typing import ClassVar

import numpy as np

from graspdsl.arrays import Array, namespace, product
from graspdsl.basis.algebra import cross, in_columns, in_rows, skew
from graspdsl.basis.entry import Entry
from graspdsl.basis.operations import by_contact, flat, times, transposed_times
from graspdsl.basis.spaces import GradientSpace


class Effector(Entry):
    """An effector transform: ``reads`` names its inputs, fields of an Observation or what the compiler makes of them.

    On the surface the k contacts move by (2k,) coordinates, in Cartesian space by a (3k,) displacement; in rotation
    space all turn as one, by (3,) exponential coordinates; in joint space the n joints move. ``parts``: the transforms
    that stand above one another in it, each of a potential of its own, moments over the curvature radius. To one that
    ``weighs_sensed`` it matters what contacts sense that do not move. One of forces that contacts answer with takes
    them for of unit stiffness: ``pressed`` is the unit of what it then is a Jacobian of.
    """

    gradient_space: ClassVar[GradientSpace]
    reads: ClassVar[tuple[str, ...]]
    parts: ClassVar[tuple[str, ...]] = ()
    weighs_sensed: ClassVar[bool] = False
    pressed: ClassVar[str] = ""

    @abstractmethod
    def evaluate(self, mixing: Array, *inputs: Array) -> Array:
        """τ, (..., d, D): rows of the task space, columns of the gradient space.

        mixing: (m, k) in joint space, (s, n) for joint sets; in rotation space (2, k), the weights in Γσ of the points
        and of the normals that turn; weights (k,) otherwise, and (2, k), those in Γτ and in Γσ, for one that
        ``weighs_sensed``.
        """

    def pullback(self, mixing: Array, gradient: Array, *inputs: Array) -> Array:
        """τᵀ∇, (..., D): a gradient (..., d) by the task as one by what is moved, without τ where it takes none."""
        return transposed_times(self.evaluate(mixing, *inputs), gradient)


def force_by_surface(weights: Array, frames: Array, stretch: Array) -> Array:
    """∂f_i/∂ψ_i = −w_i T S on the unit sphere, (..., k, 3, 2) [1/rad] (Eq. 4.4)."""
    return frames * stretch[..., None, :] * -weights[:, None, None]


def moment_by_surface(weights: Array, normals: Array, frames: Array, radius: Array) -> Array:
    """∂m_i/∂ψ_i = −w_i r [n_i]× T on the tangent plane, a displacement being r ψ, (..., k, 3, 2) [m/rad] (Eq. 4.7)."""
    return product(skew(normals), frames) * (-weights * radius)[:, None, None]


def sphere_by_cartesian(frames: Array, stretch: Array) -> Array:
    """T S Tᵀ, (..., k, 3, 3) [1]: what of displacements by x over r turns the normals of a sphere, Eq. 4.4 by 4.27."""
    return product(frames * stretch[..., None, :], namespace(frames).swapaxes(frames, -1, -2))


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
    parts = ("τ_fr", "τ_mr")

    def evaluate(self, mixing: Array, *inputs: Array) -> Array:
        """Force rows above moment rows, shape (..., 6, 2k)."""
        normals, frames, stretch, radius = inputs
        moment = moment_by_surface(mixing, normals, frames, radius) / radius
        return in_columns(namespace(frames).concatenate([force_by_surface(mixing, frames, stretch), moment], axis=-2))


class ForceResidualDisplacement(Effector):
    """τ_frx = ∂f/∂ψ (r̂_θ r̂_φ)ᵀ (Eq. 4.28): on a sphere of radius r, ∂f_i/∂x_i = −w_i T S Tᵀ / r, (..., 3, 3k) [1/m].

    With local frames T S Tᵀ = T Tᵀ = I − n nᵀ, free of the choice of surface coordinates and of their poles.
    """

    symbol = "τ_frx"
    about = "net unit force by contact displacements, surface taken for a sphere"
    equation = "4.28"
    gradient_space = GradientSpace.CARTESIAN
    reads = ("tangents", "curvature_radius")

    def evaluate(self, mixing: Array, *inputs: Array) -> Array:
        """−w T S Tᵀ / r side by side, shape (..., 3, 3k)."""
        tangents, radius = inputs
        return in_columns(tangents * (mixing / -radius)[:, None, None])

    def pullback(self, mixing: Array, gradient: Array, *inputs: Array) -> Array:
        """−w T S Tᵀ∇ / r of each contact, shape (..., 3k)."""
        tangents, radius = inputs
        return flat(times(tangents, gradient[..., None, :]) * (mixing / -radius)[:, None])


class MomentResidualDisplacement(Effector):
    """τ_mrx = ∂m/∂ψ (r̂_θ r̂_φ)ᵀ (Eq. 4.29): on a plane, ∂m_i/∂x_i = −w_i [n_i]× T Tᵀ = −w_i [n_i]×, (..., 3, 3k) [1].

    What of a displacement is along the normal, T Tᵀ = I − n nᵀ takes away, and so does [n]×.
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

    def pullback(self, mixing: Array, gradient: Array, *inputs: Array) -> Array:
        """w n × ∇ of each contact, shape (..., 3k)."""
        (normals,) = inputs
        return flat(cross(normals, gradient[..., None, :]) * mixing[:, None])


class WrenchResidualDisplacement(Effector):
    """τ_wx: τ_frx above τ_mrx / r (Sec. 4.1.3), (..., 6, 3k) [1/m]."""

    symbol = "τ_wx"
    about = "net wrench by contact displacements"
    equation = "Sec. 4.1.3"
    gradient_space = GradientSpace.CARTESIAN
    reads = ("tangents", "normals", "curvature_radius")
    parts = ("τ_frx", "τ_mrx")

    def evaluate(self, mixing: Array, *inputs: Array) -> Array:
        """Force rows above moment rows, shape (..., 6, 3k)."""
        tangents, normals, radius = inputs
        both = namespace(normals).concatenate([tangents, skew(normals)], axis=-2)
        return in_columns(both * (mixing / -radius)[:, None, None])


class WrenchResidualOverSurface(Effector):
    """τ_wsx: the derivative of the net wrench as contacts slide over the surface as it is, not over a model of it
    (Sec. 4.1.3), (..., 6, 3k) [1/m].

    By δx_i, its part P_i = I − n_i n_iᵀ along the surface, an inward normal turns by −S_i δx_i, S_i the shape operator
    of the outward one; a lever grows by δx_i; and the point c that moments are taken about goes by g_i δx_i:

        ∂ρ_f/∂x_i = −w_i S_i
        ∂ρ_m/∂x_i = −w_i ([n_i]× P_i + [x_i − c]× S_i) + g_i [ρ_f]× P_i

    with w_i the weights in Γτ and ρ_f the net force over Γσ. So φ_w is what falls, by −k ∇ε_w along the surface, and
    where it stops is a local minimum of ε_w itself.
    """

    symbol = "τ_wsx"
    about = "net wrench by contact displacements, over the surface as it is curved"
    equation = "Sec. 4.1.3"
    gradient_space = GradientSpace.CARTESIAN
    reads = ("points", "normals", "origin", "origin_shares", "shape_operators", "curvature_radius")
    weighs_sensed = True

    def evaluate(self, mixing: Array, *inputs: Array) -> Array:
        """Force rows above moment rows over r, shape (..., 6, 3k)."""
        points, normals, origin, shares, operators, radius = inputs
        xp, (moved, sensed), count = namespace(points), mixing, len(shares)
        net, inward = skew(product(sensed, normals))[..., None, :, :], normals[..., :count, :]
        levers, weights = points[..., :count, :] - origin[..., None, :], moved[:count, None, None]
        along = np.eye(3) - inward[..., :, None] * inward[..., None, :]
        carried = xp.where(weights > 0.0, shares[:, None, None], 0.0) * product(net, along)
        moment = carried - weights * (product(skew(inward), along) + product(skew(levers), operators))
        return in_columns(xp.concatenate([-weights * operators, moment / radius], axis=-2))


class ResidualRotation(Effector):
    """τ of a residual by a rotation of the object that the contacts hold (Eq. 4.38, 4.39).

    Held, the object and all contacts that touch it are one rigid body (Sec. 4.4.2): the contacts of Γτ cannot turn
    without "the entire object along with" them, nor apart from each other. So r_1 = … = r_|Γτ| = r, three coordinates
    whichever contacts are named, and a small turn δr about the point c that moments are taken about turns all of Γσ:

        lever a_j = x_j − c    → a_j + δr × a_j    of each contact of Γσ, and of the centre of mass, at which γ_g acts
        normal n_j             → n_j + δr × n_j    of each contact of Γσ; that of γ_g stays down

    With w_j the weights in Γσ, g for γ_g and sums over the contacts of Γσ without it, the product rule gives

        ∂f/∂r = −[Σ w_j n_j]×                                           where ρ_f = Σ w_j n_j + w_g n_g
        ∂m/∂r = −[Σ w_j a_j × n_j]× + w_g [n_g]× [a_g]×                 where ρ_m = Σ w_j a_j × n_j + w_g a_g × n_g

    These are what the chapter's ∂f/∂ψ ∂ψ/∂r comes to when ψ are the angles of the normals: turning a contact by δr
    moves its ψ by just what turns its normal by δr × n, so that the choice of surface coordinates cancels, their poles
    too. The tangent plane of Eq. 4.7, along which a contact slides and its normal stays, has no part in it: nothing
    slides.

    Down the gradients 2 (∂f/∂r)ᵀ ρ_f and 2 (∂m/∂r)ᵀ ρ_m the residuals of the real object fall. Without γ_g these are
    2 ρ_f × ρ_f = 0 and 2 ρ_m × ρ_m = 0, as the chapter has it under Eq. 4.41. With it the first is
    2 w_g Σ w_j n_j × n_g: zero, and ε_fr least, when the net of the contacts presses straight up against the weight.
    """

    gradient_space = GradientSpace.ROTATION


class ForceResidualRotation(ResidualRotation):
    """τ_frr = ∂f/∂r (Eq. 4.38): the normals of all contacts turn with the object, −[Σ w n]×, (..., 3, 3) [1/rad]."""

    symbol = "τ_frr"
    about = "net unit force by rotation of the held object with its contacts"
    equation = "4.38"
    reads = ("normals",)

    def evaluate(self, mixing: Array, *inputs: Array) -> Array:
        """−[Σ w n]× over the normals that turn, shape (..., 3, 3)."""
        (normals,) = inputs
        _, turning = mixing
        return -skew(product(turning, normals))


class MomentResidualRotation(ResidualRotation):
    """τ_mrr = ∂m/∂r (Eq. 4.39): levers and normals of all contacts turn with the object, and the lever of gravity,
    −[Σ w (x − c) × n]× + w_g [n_g]× [x_g − c]×, (..., 3, 3) [m/rad]."""

    symbol = "τ_mrr"
    about = "net moment by rotation of the held object with its contacts"
    equation = "4.39"
    reads = ("points", "normals", "origin")

    def evaluate(self, mixing: Array, *inputs: Array) -> Array:
        """Σ w [n]× [x − c]× over the points that turn less Σ w [x − c]× [n]× over the normals, shape (..., 3, 3)."""
        points, normals, origin = inputs
        levers, across = skew(points - origin[..., None, :]), skew(normals)
        by_lever, by_normal = product(across, levers), product(levers, across)
        xp, (carried, turning) = namespace(points), mixing
        return xp.einsum("k,...kij->...ij", carried, by_lever) - xp.einsum("k,...kij->...ij", turning, by_normal)


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
        return _mixed(mixing, jacobian)


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
        return _mixed(mixing, jacobian)


class ForceJacobian(Effector):
    """τ_f = n nᵀ ∂x/∂q, motion into the surface, which a contact of unit stiffness answers with a force along its
    normal (Eq. 4.21; means by 4.34), (..., 3m, n) [N/rad per N/m of stiffness]."""

    symbol = "τ_f"
    about = "contact forces by joint displacements, for unit stiffness"
    equation = "4.21"
    gradient_space = GradientSpace.JOINTS
    pressed = "m"
    reads = ("into", "normals")

    def evaluate(self, mixing: Array, *inputs: Array) -> Array:
        """R (n nᵀ J) stacked, shape (..., 3m, n)."""
        into, normals = inputs
        return _mixed(mixing, normals[..., :, None] * into[..., None, :])

    def pullback(self, mixing: Array, gradient: Array, *inputs: Array) -> Array:
        """Jᵀn nᵀ Rᵀ∇ of all contacts, shape (..., n)."""
        into, normals = inputs
        return transposed_times(into, namespace(normals).vecdot(product(mixing.T, by_contact(gradient)), normals))


class MomentJacobian(Effector):
    """τ_m = [x − c]× n nᵀ ∂x/∂q, the moment of the force that a contact of unit stiffness answers with, at a fixed
    lever (Sec. 3.1.2), (..., 3m, n) [N·m/rad per N/m of stiffness]."""

    symbol = "τ_m"
    about = "moments of contact forces by joint displacements, for unit stiffness"
    equation = "Sec. 3.1.2"
    gradient_space = GradientSpace.JOINTS
    pressed = "m²"
    reads = ("into", "normals", "points", "origin")

    def evaluate(self, mixing: Array, *inputs: Array) -> Array:
        """R ([x − c]× n nᵀ J) stacked, shape (..., 3m, n)."""
        into, normals, points, origin = inputs
        arms = cross(points - origin[..., None, :], normals)
        return _mixed(mixing, arms[..., :, None] * into[..., None, :])


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
        return mixing * weights


def _mixed(mixing: Array, jacobians: Array) -> Array:
    """The Jacobians (..., 3m, n) of the resources in a mixing matrix (m, k), from those of the contacts."""
    *batch, _, rows, joints = jacobians.shape
    each = product(mixing, jacobians.reshape(*batch, mixing.shape[-1], rows * joints))
    return in_rows(each.reshape(*batch, len(mixing), rows, joints))


EFFECTORS: dict[str, Effector] = {
    effector.symbol: effector
    for effector in (
        ForceResidualSurface(),
        ForceResidualDisplacement(),
        ForceResidualRotation(),
        MomentResidualSurface(),
        MomentResidualDisplacement(),
        MomentResidualRotation(),
        WrenchResidualSurface(),
        WrenchResidualDisplacement(),
        WrenchResidualOverSurface(),
        PositionJacobian(),
        OrientationJacobian(),
        ForceJacobian(),
        MomentJacobian(),
        PostureSelection(),
    )
}
