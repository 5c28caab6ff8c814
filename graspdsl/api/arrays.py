"""Arrays that a user gives: of the shape that is wanted, finite and of unit length where they must be, or refused."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from graspdsl.arrays import Array

UNIT = 1e-6  # how far from one the length of a unit vector may be


def floats(name: str, values: object) -> Array:
    """The values as floats, of any shape. Raises ValueError, saying that ``name`` was to be numbers, for others, among
    them complex ones and those that are masked."""
    try:
        array = np.asanyarray(values)
        if not (np.iscomplexobj(array) or np.ma.is_masked(array)):
            return np.asarray(array, dtype=float)
    except (TypeError, ValueError):
        pass
    raise ValueError(f"{name}: expected numbers, found {_shown(values)}")


def of_shape(name: str, array: npt.NDArray[Any], shape: tuple[int, ...]) -> None:
    """Raises ValueError for another shape."""
    if array.shape != shape:
        raise ValueError(f"{name}: expected the shape {shape}, found {array.shape}")


def finite(name: str, array: Array) -> None:
    """Raises ValueError where a number is not finite."""
    if not np.isfinite(array).all():
        raise ValueError(f"{name}: expected finite numbers, found {array[~np.isfinite(array)][0]}")


def of_unit_length(name: str, vectors: Array) -> None:
    """Raises ValueError where a vector of (..., 3) is longer or shorter than one."""
    lengths = np.linalg.norm(vectors, axis=-1)
    wrong = np.abs(lengths - 1.0) > UNIT
    if wrong.any():
        raise ValueError(f"{name}: expected unit vectors into the object, found one of length {lengths[wrong][0]:.6g}")


def _shown(values: object) -> str:
    text = repr(values)
    return text if len(text) <= 60 else f"{text[:60]}…"
