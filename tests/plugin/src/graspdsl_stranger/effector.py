"""An effector transform: how the net lever of the contacts changes when they slide."""

from __future__ import annotations

import numpy as np

from graspdsl.arrays import Array
from graspdsl.basis.algebra import in_columns
from graspdsl.basis.effectors import Effector
from graspdsl.basis.spaces import GradientSpace


class NetLeverDisplacement(Effector):
    """τ_cx = ∂σ_c/∂x: contacts slide along their tangent planes, ∂σ_c/∂x_i = w_i T Tᵀ, (..., 3, 3k) [1].

    The derivative of σ_c, the net lever of the contacts about the object's centre of mass (Roa and Suárez 2015).
    """

    symbol = "τ_cx"
    about = "net lever of the contacts by contact displacements"
    equation = "Roa and Suárez 2015"
    gradient_space = GradientSpace.CARTESIAN
    reads = ("frames",)

    def evaluate(self, mixing: Array, *inputs: Array) -> Array:
        """w T Tᵀ side by side, shape (..., 3, 3k)."""
        (frames,) = inputs
        along = frames @ np.swapaxes(frames, -1, -2)
        return in_columns(mixing[:, None, None] * along)
