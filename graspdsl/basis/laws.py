"""Control laws: how the gradient of a potential becomes a displacement in its gradient space."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import ClassVar, Protocol

import numpy as np

from graspdsl.arrays import Array
from graspdsl.basis import operations
from graspdsl.basis.algebra import damped_pseudo_inverse, pseudo_inverse, scaled_transpose
from graspdsl.basis.effectors import Effector
from graspdsl.basis.resources import ContactSet, JointSet
from graspdsl.basis.spaces import GradientSpace

POSTURE_STEP = 5e-4  # of scaled joint displacement a tick: about half a millimetre at a fingertip


class Bench(Protocol):
    """What a law works with: steps of a pipeline, told by their numbers, and what they are made for.

    ``rate`` [Hz] of the ticks; ``step``: the displacement [m] of a contact for a unit net force, once ``each`` tick or
    probe; ``held``: whether the object is fixed to the hand; ``transposes``: whether transposes stand for inverses.
    """

    rate: float
    step: float
    each: str
    held: bool
    transposes: bool

    def setting(self, key: str) -> float:
        """A number of the spec's control settings, by its key there."""
        ...

    def apply(self, label: str, about: str, function: Callable[..., Array], *inputs: int) -> int:
        """The step that applies a function to the values of earlier steps."""
        ...

    def read(self, name: str) -> int:
        """The step that reads a field of the observation, or a quantity made of one."""
        ...

    def mixing(self, resources: ContactSet) -> Array:
        """The rows (m, k) of per-contact tasks."""
        ...

    def fingers(self, resources: ContactSet) -> Array:
        """(k, n): ones at the joints of each contact's own finger; zero rows for contacts outside the set."""
        ...


@dataclass(frozen=True, slots=True)
class Slope:
    """Where a law begins: the steps of ∇φ (``gradient``) and τ (``task``) of a controller, and what these are of.

    ``symbol`` and ``source`` are those of the potential, ``resources`` those of the effector transform. ``pullback``:
    what makes the step of τᵀ times a vector (..., d), with a label and what is said of it.
    """

    symbol: str
    source: str
    effector: Effector
    resources: ContactSet | JointSet
    gradient: int
    task: int
    pullback: Callable[[str, str, int], int]

    @property
    def contacts(self) -> ContactSet:
        """The contacts of a controller that the checker has found to act on contacts."""
        assert isinstance(self.resources, ContactSet)
        return self.resources


@dataclass(frozen=True)
class Law(ABC):
    """A way from ∇φ and τ to a displacement.

    ``gain``: the key of the control setting that scales it and may be zero, of which the potential then does what is
    said in ``without``. ``of_moments``: the error is of moments, each that of a force at the curvature radius.
    ``damped``: it goes by an inverse that the damping of the control settings may hold back.
    """

    gain: str = ""
    of_moments: bool = False
    without: ClassVar[str] = ""
    damped: ClassVar[bool] = False

    @abstractmethod
    def displacement(self, bench: Bench, slope: Slope) -> int:
        """The step of the controller's displacement, (..., D) in its gradient space."""


@dataclass(frozen=True)
class Descent(Law):
    """−k τᵀ∇φ: a unit net force moves a contact by ``step``; a moment weighs as a force at the curvature radius.

    In surface coordinates and in rotations it moves or turns by that over the curvature radius.
    """

    without = "moves no contact"

    def displacement(self, bench: Bench, slope: Slope) -> int:
        """Down the gradient, scaled."""
        radius, step, space = bench.setting("curvature_radius"), bench.step, slope.effector.gradient_space
        factor = bench.setting(self.gain) if self.gain else 1.0
        gain = 0.5 * step * factor / radius if self.of_moments else 0.5 * step * factor * radius
        turns = space is not GradientSpace.CARTESIAN
        gain, moved = (gain / radius**2, f"{step / radius:.3g} rad") if turns else (gain, f"{1000 * step:.3g} mm")
        name = slope.symbol
        about = f"gradient in {space.value}, {slope.effector.source}"
        gradient = slope.pullback(f"τᵀ∇{name}", about, slope.gradient)
        what = f"a moment of {1000 * radius:.3g} mm" if self.of_moments else "a unit net force"
        what += f", × {factor:g}" if self.gain else ""
        about = f"step down it, k = {gain:.3g}: {moved} a {bench.each} for {what}"
        return bench.apply(f"−k∇{name}", about, partial(np.multiply, gain), gradient)


@dataclass(frozen=True)
class InverseKinematics(Law):
    """K_p J⁺e, J⁺ a pseudo-inverse or a transpose, while all contacts touch; else they wait (Eq. 4.20)."""

    damped = True

    def displacement(self, bench: Bench, slope: Slope) -> int:
        """What takes the error back, gated by touch."""
        name, damping, gain = slope.symbol, bench.setting("damping"), bench.setting("position_gain")
        if bench.transposes:
            inverse = bench.apply("Jᵀ/σ²", "transpose, σ the largest singular value", scaled_transpose, slope.task)
        else:
            invert = partial(damped_pseudo_inverse, damping)
            inverse = bench.apply("J⁺", f"damped pseudo-inverse, λ = {damping:g}", invert, slope.task)
        about = f"joint displacement, {slope.source}"
        moved = bench.apply(f"J⁺∇{name}", about, operations.times, inverse, slope.gradient)
        if gain != 1.0:
            moved = bench.apply(f"K_p Δ{name}", f"{gain:g} of it a tick", partial(np.multiply, gain), moved)
        if bench.held:
            return moved
        resources = slope.contacts
        members = np.isin(np.arange(resources.count), resources.contacts).astype(float)
        check = partial(operations.all_touch, members)
        gate = bench.apply("touch", "1 when every contact touches", check, bench.read("touching"))
        return bench.apply(f"Δ{name}", "held while a contact is lost", operations.gated, moved, gate)


@dataclass(frozen=True)
class Pressing(Law):
    """Admittance times Jᵀe for contacts that touch; the others approach along their normals, finger by finger."""

    gain: str = "admittance"
    without = "does not press"

    def displacement(self, bench: Bench, slope: Slope) -> int:
        """Servo and approach."""
        resources, name, radius = slope.contacts, slope.symbol, bench.setting("curvature_radius")
        fastest, admittance = bench.setting("approach") / bench.rate, bench.setting(self.gain)
        close = partial(operations.approach, bench.fingers(resources), fastest)
        closing = f"contacts that do not touch close with their own fingers, {fastest:.3g} m a tick"
        unit, most = "m/N", "m"
        if self.of_moments:
            admittance, unit, most = admittance / radius**2, "1/(N·m)", "rad"
            fastest /= radius
        check = partial(operations.row_touches, bench.mixing(resources))
        touching = bench.apply("touch(Γ)", "1 for each resource that touches", check, bench.read("touching"))
        rows = bench.apply(f"∇{name}(Γ)", "by resource", operations.by_contact, slope.gradient)
        press = partial(operations.pressing, admittance, fastest)
        about = f"admittance {admittance:g} {unit} a tick, capped at {fastest:.3g} {most} a tick"
        pressed = bench.apply("k e", about, press, rows, touching)
        pressed = bench.apply("k e", "flattened", operations.flat, pressed)
        about = f"joint displacement, {slope.source}"
        servo = slope.pullback("τᵀ k e", about, pressed)
        approach = bench.apply("approach", closing, close, bench.read("into"), bench.read("touching"))
        return bench.apply(f"Δ{name}", "servo + approach", np.add, servo, approach)


@dataclass(frozen=True)
class ShareOfError(Law):
    """A share of the posture error, τ⁺e: the joints of Γσ that Γτ moves go that part of the way (Eq. 4.25)."""

    def displacement(self, bench: Bench, slope: Slope) -> int:
        """Part of the way, and no more than POSTURE_STEP a tick."""
        name, gain = slope.symbol, bench.setting("posture_gain")
        inverse = bench.apply("τ⁺", "pseudo-inverse", pseudo_inverse, slope.task)
        moved = bench.apply(f"τ⁺∇{name}", "joint displacement, Eq. 4.25", operations.times, inverse, slope.gradient)
        part = bench.apply(f"k Δ{name}", f"{gain:g} of it a tick", partial(np.multiply, gain), moved)
        slow = partial(operations.limited, POSTURE_STEP)
        return bench.apply(f"Δ{name}", f"no more than {POSTURE_STEP:g} a tick", slow, part)
