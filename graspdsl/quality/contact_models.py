"""Contact models: which forces and moments a contact can pass on for one newton along its normal.

After Murray, Li and Sastry, "A Mathematical Introduction to Robotic Manipulation", 1994, section 5.2.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from graspdsl.arrays import Array

DEFAULT_EDGES = 16


class ContactModel(Protocol):
    """A contact model in its own frame: inward normal, two tangents."""

    @property
    def name(self) -> str:
        """The model and its coefficients in words."""
        ...

    def generators(self) -> Array:
        """The (m, 4) edges of the set of contact wrenches of unit normal force: normal, two tangential forces (1), and
        moment about the normal [m]."""
        ...


@dataclass(frozen=True, slots=True)
class FrictionlessPoint:
    """A contact that only pushes along its normal."""

    @property
    def name(self) -> str:
        """The model in words."""
        return "frictionless point contact"

    def generators(self) -> Array:
        """One edge, the normal."""
        return np.array([[1.0, 0.0, 0.0, 0.0]])


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

    def generators(self) -> Array:
        """The edges of the pyramid; without friction, the normal alone."""
        if self.friction == 0.0:
            return FrictionlessPoint().generators()
        angles = 2.0 * math.pi * np.arange(self.edges) / self.edges
        one, none = np.ones(self.edges), np.zeros(self.edges)
        return np.column_stack([one, self.friction * np.cos(angles), self.friction * np.sin(angles), none])


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
        return f"soft finger contact, μ = {self.friction:g}, μ_t = {1000 * self.torsion:g} mm"

    def generators(self) -> Array:
        """The edges of the pyramid, each with the largest moment either way about the normal."""
        cone = HardPoint(self.friction, self.edges).generators()
        if self.torsion == 0.0:
            return cone
        moment = np.array([0.0, 0.0, 0.0, self.torsion])
        return np.vstack([cone + moment, cone - moment])


def _check(friction: float, edges: int) -> None:
    if not 0.0 <= friction < math.inf:
        raise ValueError(f"a friction coefficient is not negative, found {friction}")
    if edges < 4 or edges % 2:
        raise ValueError(f"a friction pyramid has an even number of edges, 4 or more, found {edges}")
