"""How soft fingertips give way: linear springs under light forces, Hertz's law of the sphere above."""

from __future__ import annotations

import numpy as np

from graspdsl.arrays import Array

STIFFNESS = 1500.0  # N/m: about a third of a millimetre at 0.5 N
DAMPING = 30.0  # N·s/m
LINEAR_FORCE = 1.0  # N, above which a fingertip hardens


def stiffness_under(force: float) -> float:
    """The secant stiffness [N/m] of a fingertip that presses with a force [N].

    Above LINEAR_FORCE the dent grows with the force's power 2/3, as Hertz has it for a sphere (K. L. Johnson, Contact
    Mechanics, 1985, chapter 4), so that the stiffness grows with its power 1/3.
    """
    return float(STIFFNESS * max(1.0, force / LINEAR_FORCE) ** (1.0 / 3.0))


def force_of_dent(dent: Array, stiffness: float = STIFFNESS) -> Array:
    """The forces (...) [N] that dents (...) [m] take, none where a dent is negative.

    stiffness [N/m]: that under light forces.
    """
    linear = np.maximum(0.0, stiffness * dent)
    return np.asarray(linear * np.sqrt(np.maximum(1.0, linear / LINEAR_FORCE)))
