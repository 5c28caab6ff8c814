"""Numbers as messages have them."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from graspdsl.arrays import Array


def shown(numbers: Array | Sequence[float]) -> str:
    """A few numbers of any shape on one line, to three digits."""
    return f"({', '.join(f'{number:.3g}' for number in np.ravel(numbers))})"
