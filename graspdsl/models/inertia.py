"""Moments of inertia that no body has, and the nearest that one has."""

from __future__ import annotations

import numpy as np

from graspdsl.arrays import Array

ROUNDING = 1e-2  # of the largest principal moment: what three digits leave open
LEAST = 1e-9  # of the largest principal moment
APART = 1e-10  # of the largest moment: engines compare without tolerance
ARM = 0.005  # m: the radius of gyration of a body that has a mass and says no inertia


def physical(tensor: Array, mass: float) -> Array:
    """The nearest inertia (3, 3) whose principal moments are positive and none above the sum of the others; that of a
    body of a mass [kg] which says none is of a small ball. The same where nothing is to mend."""
    if mass > 0.0 and not tensor.any():
        return mass * ARM**2 * np.eye(3)
    moments, axes = np.linalg.eigh(tensor)
    least, middle, most = moments
    if least >= LEAST * most and most <= (1.0 - APART) * (least + middle):
        return tensor
    least = max(least, LEAST * most)
    middle = max(middle, least)
    short = most - (1.0 - APART) * (least + middle)
    if short > 0.0:  # each of the three gives in by a third
        least, middle, most = least + short / 3.0, middle + short / 3.0, most - short / 3.0
        most = min(most, (1.0 - APART) * (least + middle))
    mended: Array = axes * np.array([least, middle, most]) @ axes.T
    return mended
