"""Contact models: which forces and moments a contact can pass on for one newton along its normal.

After Murray, Li and Sastry, "A Mathematical Introduction to Robotic Manipulation", 1994, section 5.2.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from graspdsl.arrays import Array
from graspdsl.spec.grading import DEFAULT_EDGES, ContactKind
from graspdsl.worlds.touch.compliance import LINEAR_FORCE, STIFFNESS

FEW = 2  # contacts, that hard points cannot make a grasp of: they never resist turning about the line between them
TIP_RADIUS = 0.0115  # m, of a Barrett fingertip
DENT = LINEAR_FORCE / STIFFNESS  # m
PATCH = math.sqrt(TIP_RADIUS * DENT)  # m, the radius of the patch that a ball touches a plane with (Hertz)


class ContactModel(Protocol):
    """A contact model in its own frame: inward normal, two tangents.

    Contact wrenches have four components: normal force, two tangential forces, and moment about the normal.
    """

    @property
    def name(self) -> str:
        """The model and its coefficients in words."""
        ...

    @property
    def components(self) -> int:
        """How many of the four components, the first ones, the contact can pass on."""
        ...

    def generators(self) -> Array:
        """The (m, 4) edges of the set of contact wrenches of unit normal force: normal, two tangential forces (1), and
        moment about the normal [m]."""
        ...

    def support(self, directions: Array) -> Array:
        """How far (...) the set itself, with a round cone, reaches along directions (..., 4)."""
        ...


def contact_model(
    contact: ContactKind | None, count: int, friction: float, torsion: float | None, edges: int
) -> ContactModel:
    """The model of so many contacts that touch: of the kind that is asked for, or a soft finger for no more than two or
    where a torsion [m] is given, and a hard point else.

    Two hard points never close a grasp, for they cannot twist the object about the line between them: the chapter has
    its argument for two contacts made with soft ones (Sec. 4.1.3). It is about the contacts that touch, so that a thumb
    against a virtual contact of two fingers is a grasp of three. A soft finger's torsion is by default (3π/16) μ a of a
    patch of the radius a = PATCH. Raises ValueError for other kinds, coefficients below 0 and odd numbers of edges.
    """
    if contact is None:
        contact = "soft-finger" if count <= FEW or torsion is not None else "hard"
    match contact:
        case "frictionless":
            return FrictionlessPoint()
        case "hard":
            return HardPoint(friction, edges)
        case "soft-finger":
            return SoftFinger(friction, 3.0 * math.pi / 16.0 * friction * PATCH if torsion is None else torsion, edges)
    raise ValueError(f"a contact is hard, soft-finger or frictionless, found {contact!r}")


@dataclass(frozen=True, slots=True)
class FrictionlessPoint:
    """A contact that only pushes along its normal."""

    @property
    def name(self) -> str:
        """The model in words."""
        return "frictionless point contact"

    @property
    def components(self) -> int:
        """The force along its normal."""
        return 1

    def generators(self) -> Array:
        """One edge, the normal."""
        return np.array([[1.0, 0.0, 0.0, 0.0]])

    def support(self, directions: Array) -> Array:
        """The part along the normal."""
        return np.asarray(directions[..., 0])


@dataclass(frozen=True, slots=True)
class HardPoint:
    """A point contact with Coulomb friction: |f_t| ≤ μ f_n, a cone replaced by a pyramid inside it.

    edges: even, so that the sign of a tangent does not matter. Raises ValueError for other numbers.
    """

    friction: float
    edges: int = DEFAULT_EDGES

    def __post_init__(self) -> None:
        _check(self.friction, self.edges)

    @property
    def name(self) -> str:
        """The model and its coefficient in words."""
        return f"hard point contact, μ = {self.friction:g}"

    @property
    def components(self) -> int:
        """The three of its force."""
        return 3

    def generators(self) -> Array:
        """The edges of the pyramid; without friction, the normal alone."""
        if self.friction == 0.0:
            return FrictionlessPoint().generators()
        angles = 2.0 * math.pi * np.arange(self.edges) / self.edges
        one, none = np.ones(self.edges), np.zeros(self.edges)
        return np.column_stack([one, self.friction * np.cos(angles), self.friction * np.sin(angles), none])

    def support(self, directions: Array) -> Array:
        """d_n + μ |d_t|."""
        sideways = np.hypot(directions[..., 1], directions[..., 2])
        return np.asarray(directions[..., 0] + self.friction * sideways)


@dataclass(frozen=True, slots=True)
class SoftFinger:
    """A hard point contact that also resists turning about its normal: |m_n| ≤ μ_t f_n, μ_t = ``torsion`` [m].

    Both limits hold by themselves; the limit surface of a real patch, an ellipsoid, lies within. For a round patch of
    radius a [m] under Hertz's pressure its half axis, the largest μ_t, is (3π/16) μ a (Howe and Cutkosky, "Practical
    force-motion models for sliding manipulation", 1996).
    """

    friction: float
    torsion: float
    edges: int = DEFAULT_EDGES

    def __post_init__(self) -> None:
        _check(self.friction, self.edges)
        if not 0.0 <= self.torsion < math.inf:
            raise ValueError(f"a torsional coefficient is not negative, found {self.torsion}")

    @property
    def name(self) -> str:
        """The model and its coefficients in words."""
        return f"soft finger contact, μ = {self.friction:g}, μ_t = {1000 * self.torsion:.3g} mm"

    @property
    def components(self) -> int:
        """Its force and its moment about the normal."""
        return 4

    def generators(self) -> Array:
        """The edges of the pyramid, each with the largest moment either way about the normal."""
        cone = HardPoint(self.friction, self.edges).generators()
        if self.torsion == 0.0:
            return cone
        moment = np.array([0.0, 0.0, 0.0, self.torsion])
        return np.vstack([cone + moment, cone - moment])

    def support(self, directions: Array) -> Array:
        """d_n + μ |d_t| + μ_t |d_m|."""
        cone = HardPoint(self.friction, self.edges).support(directions)
        return np.asarray(cone + self.torsion * np.abs(directions[..., 3]))


def _check(friction: float, edges: int) -> None:
    if not 0.0 <= friction < math.inf:
        raise ValueError(f"a friction coefficient is not negative, found {friction}")
    if edges < 4 or edges % 2:
        raise ValueError(f"a friction pyramid has an even number of edges, 4 or more, found {edges}")
