"""Points spread as asked, by rejection: exact, whatever the shape."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from graspdsl.arrays import Array

LEAST_DRAW = 64


def accepted(
    count: int, random: np.random.Generator, draw: Callable[[int, np.random.Generator], tuple[Array, Array]]
) -> Array:
    """``count`` draws, kept with their chances.

    ``draw(n, random)`` gives n candidates (n, ...) and the chance (n,) in [0, 1] that each is kept; the chances must
    be proportional to the wanted density over the drawn one.
    """
    kept: list[Array] = []
    missing = count
    while missing > 0 or not kept:
        candidates, chances = draw(max(2 * missing, LEAST_DRAW), random)
        kept.append(candidates[random.random(len(candidates)) < chances][:missing])
        missing -= len(kept[-1])
    return np.concatenate(kept)
