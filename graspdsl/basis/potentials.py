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
    that can make its reference. Without any, the reference is zero and none is written.
    """

    symbol: ClassVar[str]
    about: ClassVar[str]
    equation: ClassVar[str]
    space: ClassVar[TaskSpace]
    sensors: ClassVar[tuple[str, ...]]
    effectors: ClassVar[tuple[str, ...]]
    references: ClassVar[tuple[str, ...]] = ()

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
    effectors = ("τ_fr", "τ_frx")


class MomentResidual(Squared):
    """φ_mr = ρ_mᵀρ_m = ε_mr, the squared net moment of frictionless unit contact forces (Eq. 4.2). In m²."""

    symbol = "φ_mr"
    about = "moment residual: the squared net moment of unit contact forces"
    equation = "4.2"
    space = TaskSpace.NET_MOMENT
    sensors = ("σ_mr",)
    effectors = ("τ_mr", "τ_mrx")


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


POTENTIALS: Mapping[str, Potential] = {
    potential.symbol: potential for potential in (ForceResidual(), MomentResidual(), Position(), Force())
}
