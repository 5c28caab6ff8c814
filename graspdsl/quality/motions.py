"""How the hand moves in a test: displacements of the palm over time."""

from __future__ import annotations

import math


def rise(share: float) -> float:
    """From 0 to 1 as ``share`` of the time goes from 0 to 1, with the least jerk: 10 s³ − 15 s⁴ + 6 s⁵.

    Over a height h in a time T the acceleration is at most 5.774 h / T².
    """
    s = min(1.0, max(0.0, share))
    return s**3 * (10.0 + s * (6.0 * s - 15.0))


def sway(cycles: float, count: int) -> float:
    """sin(2π c) after c of a whole number of cycles, its first and last half cycle swelling from rest and back.

    At amplitude A and angular frequency ω the acceleration is about A ω² in whole cycles.
    """
    if not 0.0 < cycles < count:
        return 0.0
    return math.sin(2.0 * math.pi * cycles) * rise(2.0 * cycles) * rise(2.0 * (count - cycles))
