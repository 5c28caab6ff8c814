"""A potential: contacts that gather about the object's centre of mass, from afar at an even pace."""

from __future__ import annotations

import numpy as np

from graspdsl.arrays import Array
from graspdsl.basis.laws import Descent
from graspdsl.basis.potentials import Potential
from graspdsl_stranger.sensor import NET_LEVER

BEND = 0.05  # m


class Centring(Potential):
    """φ_c = 2b² (√(1 + eᵀe/b²) − 1) of the net lever e of the contacts, b = 0.05 m. In m².

    The pseudo-Huber function (Hartley and Zisserman 2004, A6.8): eᵀe near zero, and no steeper than 2b far away.
    """

    symbol = "φ_c"
    about = "centring: the contacts' centroid to the object's centre of mass"
    equation = "Hartley and Zisserman 2004, A6.8"
    space = NET_LEVER
    sensors = ("σ_c",)
    effectors = ("τ_cx",)
    law = Descent(of_moments=True)
    is_residual = True

    def value(self, error: Array) -> Array:
        """2b² (√(1 + eᵀe/b²) − 1), shape (...)."""
        return np.asarray(2.0 * BEND**2 * (_bent(error) - 1.0))

    def gradient(self, error: Array) -> Array:
        """2e / √(1 + eᵀe/b²), shape (..., d)."""
        return np.asarray(2.0 * error / _bent(error)[..., None])


def _bent(error: Array) -> Array:
    return np.asarray(np.sqrt(1.0 + np.einsum("...i,...i->...", error, error) / BEND**2))
