"""Potential functions φ: how far an error is from zero, and which way is down."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from graspdsl.arrays import Array, namespace
from graspdsl.basis.entry import Entry
from graspdsl.basis.laws import Descent, InverseKinematics, Law, Pressing, ShareOfError
from graspdsl.basis.rotations import turn_between, turned
from graspdsl.basis.spaces import (
    FORCE,
    MOMENT,
    NET_FORCE,
    NET_MOMENT,
    NET_WRENCH,
    ORIENTATION,
    POSITION,
    POSTURE,
    GradientSpace,
    TaskSpace,
)


@dataclass(frozen=True, slots=True)
class Difference:
    """How places (..., 3) of a task space differ.

    ``between(end, start)``: the displacement from one to the other; ``displaced(by, start)``: where a displacement
    leads. ``label``: of a displacement. ``turns``: displacements are rotations [rad], which all contacts of a rigid
    body share; else they are vectors.
    """

    between: Callable[[Array, Array], Array]
    displaced: Callable[[Array, Array], Array]
    label: str
    turns: bool = False


STRAIGHT = Difference(np.subtract, np.add, "Δx")
TURNING = Difference(turn_between, turned, "Δr", turns=True)


class Potential(Entry):
    """A potential over errors e = reference − sensed, with e flattened to (..., d).

    ``sensors`` and ``effectors`` are the transforms it can be joined with; ``references`` the sensors
    that can make its reference. Without any, the reference is zero and none is written; one that may be left out is
    said in ``has_default_reference``. A gradient in the space ``displaced_by`` can be its reference: sensed +
    displacement. ``is_capped``: a far reference is approached in steps of the cap.

    ``lowers``: the end conditions of a phase that it works towards, by their names in a spec. One that ``is_residual``
    is of the net of a set of contacts, which then is the grasp that a phase is judged by. ``normal_to``: the potentials
    to which its gradient is at right angles where all contacts are controlled alike. One that ``adds_up`` asks contacts
    for what adds up on the object, as forces do: members of a virtual contact can share it.
    """

    space: ClassVar[TaskSpace]
    sensors: ClassVar[tuple[str, ...]]
    effectors: ClassVar[tuple[str, ...]]
    references: ClassVar[tuple[str, ...]] = ()
    has_default_reference: ClassVar[bool] = False
    law: ClassVar[Law]
    difference: ClassVar[Difference] = STRAIGHT
    displaced_by: ClassVar[GradientSpace | None] = None
    is_capped: ClassVar[bool] = False
    lowers: ClassVar[tuple[str, ...]] = ()
    is_residual: ClassVar[bool] = False
    normal_to: ClassVar[tuple[str, ...]] = ()
    adds_up: ClassVar[bool] = False

    @abstractmethod
    def value(self, error: Array) -> Array:
        """φ(e), shape (...)."""

    @abstractmethod
    def gradient(self, error: Array) -> Array:
        """dφ/de, shape (..., d)."""


class Residual(Potential):
    """φ(e) = eᵀe of a residual e, which falls down its gradient."""

    law = Descent()
    is_residual = True

    def value(self, error: Array) -> Array:
        """eᵀe, shape (...)."""
        return namespace(error).einsum("...i,...i->...", error, error)

    def gradient(self, error: Array) -> Array:
        """2e, shape (..., d)."""
        return 2.0 * error


class HalfSquared(Potential):
    """φ(e) = ½ eᵀe, so that a unit step of the pseudo-inverse removes a small error at once."""

    def value(self, error: Array) -> Array:
        """½ eᵀe, shape (...)."""
        return 0.5 * namespace(error).einsum("...i,...i->...", error, error)

    def gradient(self, error: Array) -> Array:
        """e, shape (..., d)."""
        return error


class ForceResidual(Residual):
    """φ_fr = ρ_fᵀρ_f = ε_fr, the squared net force of frictionless unit contact forces (Eq. 4.1). Dimensionless."""

    symbol = "φ_fr"
    about = "force residual: the squared net force of unit contact forces"
    equation = "4.1"
    space = NET_FORCE
    sensors = ("σ_fr",)
    effectors = ("τ_fr", "τ_frx", "τ_frr")
    lowers = ("force_residual",)
    normal_to = ("φ_mr",)


class MomentResidual(Residual):
    """φ_mr = ρ_mᵀρ_m = ε_mr, the squared net moment of frictionless unit contact forces (Eq. 4.2). In m²."""

    symbol = "φ_mr"
    about = "moment residual: the squared net moment of unit contact forces"
    equation = "4.2"
    space = NET_MOMENT
    sensors = ("σ_mr",)
    effectors = ("τ_mr", "τ_mrx", "τ_mrr")
    law = Descent(gain="moment_gain", of_moments=True)
    lowers = ("moment_residual",)


class Position(HalfSquared):
    """φ_p = ½‖x_ref − σ_p‖², the distance of contacts from reference positions (Eq. 4.20). In m²."""

    symbol = "φ_p"
    about = "position: contacts to reference positions"
    equation = "4.20"
    space = POSITION
    sensors = ("σ_p",)
    effectors = ("τ_p",)
    references = ("σ_p",)
    law = InverseKinematics()
    displaced_by = GradientSpace.CARTESIAN
    is_capped = True


class Force(HalfSquared):
    """φ_f = ½‖f_ref − σ_f‖², the distance of contact forces from reference forces (Eq. 4.21). In N²."""

    symbol = "φ_f"
    about = "force: contact forces to reference forces"
    equation = "4.21"
    space = FORCE
    sensors = ("σ_f",)
    effectors = ("τ_f",)
    references = ("σ_f", "σ_n")
    law = Pressing()
    lowers = ("force_error",)
    adds_up = True


class WrenchResidual(Residual):
    """φ_w = ρ_wᵀρ_w, force and moment residual in one, for contrast: it has local minima that the two apart have not
    (Sec. 4.1.3). Dimensionless, the moment taken over the curvature radius."""

    symbol = "φ_w"
    about = "wrench residual: squared net force and moment in one"
    equation = "Sec. 4.1.3"
    space = NET_WRENCH
    sensors = ("σ_w",)
    effectors = ("τ_w", "τ_wx", "τ_wsx")
    lowers = ("force_residual", "moment_residual")


class Orientation(HalfSquared):
    """φ_r = ½‖r_ref − σ_r‖², the angle of contacts from reference orientations (Eq. 4.41). In rad²."""

    symbol = "φ_r"
    about = "orientation: contacts to reference orientations"
    equation = "4.41"
    space = ORIENTATION
    sensors = ("σ_r",)
    effectors = ("τ_r",)
    references = ("σ_r",)
    law = InverseKinematics()
    difference = TURNING
    displaced_by = GradientSpace.ROTATION
    is_capped = True


class Moment(HalfSquared):
    """φ_m = ½‖m_ref − σ_m‖², the distance of contact moments from reference moments (Sec. 3.1.2). In (N·m)²."""

    symbol = "φ_m"
    about = "moment: moments of contact forces to reference moments"
    equation = "Sec. 3.1.2"
    space = MOMENT
    sensors = ("σ_m",)
    effectors = ("τ_m",)
    references = ("σ_m",)
    law = Pressing(of_moments=True)
    adds_up = True


class PostureDistance(HalfSquared):
    """φ_k = ½‖q_ref − σ_k‖², the distance of joints from a reference posture (Eq. 4.25). In rad².

    Without a reference in the formula, it is the middle of the joints' ranges, as in Sec. 4.3.2.
    """

    symbol = "φ_k"
    about = "posture: joints to a reference posture, by default the middle of their ranges"
    equation = "4.25"
    space = POSTURE
    sensors = ("σ_k",)
    effectors = ("τ_k",)
    references = ("σ_k",)
    has_default_reference = True
    law = ShareOfError()


POTENTIALS: dict[str, Potential] = {
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


def lowering() -> Mapping[str, tuple[Potential, ...]]:
    """The end conditions that a phase can wait for, by their names in a spec, with the potentials that lower each."""
    names = dict.fromkeys(name for potential in POTENTIALS.values() for name in potential.lowers)
    return {name: tuple(known for known in POTENTIALS.values() if name in known.lowers) for name in names}


def displaced_in(space: GradientSpace) -> Potential:
    """The potential whose reference a gradient in a space can be."""
    return next(potential for potential in POTENTIALS.values() if potential.displaced_by is space)
