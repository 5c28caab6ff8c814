"""Potential functions φ: how far an error is from zero, and which way is down."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping
from typing import ClassVar

import numpy as np

from graspdsl.arrays import Array
from graspdsl.basis.spaces import TaskSpace


class Potential(ABC):
    """A potential over errors e = reference − sensed, with e flattened to (..., d).

    ``sensors`` and ``effectors`` are the transforms it can be joined with; ``references`` the sensors
    that can make its reference. Without any, the reference is zero and none is written; one that may be left out is
    said in ``has_default_reference``.
    """

    symbol: ClassVar[str]
    about: ClassVar[str]
    equation: ClassVar[str]
    space: ClassVar[TaskSpace]
    sensors: ClassVar[tuple[str, ...]]
    effectors: ClassVar[tuple[str, ...]]
    references: ClassVar[tuple[str, ...]] = ()
    has_default_reference: ClassVar[bool] = False

    @abstractmethod
    def value(self, error: Array) -> Array:
        """φ(e), shape (...)."""

    @abstractmethod
    def gradient(self, error: Array) -> Array:
        """dφ/de, shape (..., d)."""


class Squared(Potential):
    """φ(e) = eᵀe."""

    def value(self, error: Array) -> Array:
        """eᵀe, shape (...)."""
        return np.asarray(np.einsum("...i,...i->...", error, error))

    def gradient(self, error: Array) -> Array:
        """2e, shape (..., d)."""
        return 2.0 * error


class HalfSquared(Potential):
    """φ(e) = ½ eᵀe, so that a unit step of the pseudo-inverse removes a small error at once."""

    def value(self, error: Array) -> Array:
        """½ eᵀe, shape (...)."""
        return np.asarray(0.5 * np.einsum("...i,...i->...", error, error))

    def gradient(self, error: Array) -> Array:
        """e, shape (..., d)."""
        return error


class ForceResidual(Squared):
    """φ_fr = ρ_fᵀρ_f = ε_fr, the squared net force of frictionless unit contact forces (Eq. 4.1). Dimensionless."""

    symbol = "φ_fr"
    about = "force residual: the squared net force of unit contact forces"
    equation = "4.1"
    space = TaskSpace.NET_FORCE
    sensors = ("σ_fr",)
    effectors = ("τ_fr", "τ_frx", "τ_frr")


class MomentResidual(Squared):
    """φ_mr = ρ_mᵀρ_m = ε_mr, the squared net moment of frictionless unit contact forces (Eq. 4.2). In m²."""

    symbol = "φ_mr"
    about = "moment residual: the squared net moment of unit contact forces"
    equation = "4.2"
    space = TaskSpace.NET_MOMENT
    sensors = ("σ_mr",)
    effectors = ("τ_mr", "τ_mrx", "τ_mrr")


class Position(HalfSquared):
    """φ_p = ½‖x_ref − σ_p‖², the distance of contacts from reference positions (Eq. 4.20). In m²."""

    symbol = "φ_p"
    about = "position: contacts to reference positions"
    equation = "4.20"
    space = TaskSpace.POSITION
    sensors = ("σ_p",)
    effectors = ("τ_p",)
    references = ("σ_p",)


class Force(HalfSquared):
    """φ_f = ½‖f_ref − σ_f‖², the distance of contact forces from reference forces (Eq. 4.21). In N²."""

    symbol = "φ_f"
    about = "force: contact forces to reference forces"
    equation = "4.21"
    space = TaskSpace.FORCE
    sensors = ("σ_f",)
    effectors = ("τ_f",)
    references = ("σ_f", "σ_n")


class WrenchResidual(Squared):
    """φ_w = ρ_wᵀρ_w, force and moment residual in one, for contrast: it has local minima that the two apart have not
    (Sec. 4.1.3). Dimensionless, the moment taken over the curvature radius."""

    symbol = "φ_w"
    about = "wrench residual: squared net force and moment in one"
    equation = "Sec. 4.1.3"
    space = TaskSpace.NET_WRENCH
    sensors = ("σ_w",)
    effectors = ("τ_w", "τ_wx")


class Orientation(HalfSquared):
    """φ_r = ½‖r_ref − σ_r‖², the angle of contacts from reference orientations (Eq. 4.41). In rad²."""

    symbol = "φ_r"
    about = "orientation: contacts to reference orientations"
    equation = "4.41"
    space = TaskSpace.ORIENTATION
    sensors = ("σ_r",)
    effectors = ("τ_r",)
    references = ("σ_r",)


class Moment(HalfSquared):
    """φ_m = ½‖m_ref − σ_m‖², the distance of contact moments from reference moments (Sec. 3.1.2). In (N·m)²."""

    symbol = "φ_m"
    about = "moment: moments of contact forces to reference moments"
    equation = "Sec. 3.1.2"
    space = TaskSpace.MOMENT
    sensors = ("σ_m",)
    effectors = ("τ_m",)
    references = ("σ_m",)


class PostureDistance(HalfSquared):
    """φ_k = ½‖q_ref − σ_k‖², the distance of joints from a reference posture (Eq. 4.25). In rad².

    Without a reference in the formula, it is the middle of the joints' ranges, as in Sec. 4.3.2.
    """

    symbol = "φ_k"
    about = "posture: joints to a reference posture, by default the middle of their ranges"
    equation = "4.25"
    space = TaskSpace.POSTURE
    sensors = ("σ_k",)
    effectors = ("τ_k",)
    references = ("σ_k",)
    has_default_reference = True


POTENTIALS: Mapping[str, Potential] = {
    potential.symbol: potential
    for potential in (
        ForceResidual(),
        MomentResidual(),
        WrenchResidual(),
        Position(),
        Orientation(),
        Force(),
        Moment(),
        PostureDistance(),
    )
}
