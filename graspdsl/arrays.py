"""The array types that everything numeric shares, and the functions of arrays that serve more than one backend.

What a tick computes is written once, against the :class:`Namespace` of the arrays that it is given: numpy's own, which
serves all arrays that follow numpy's protocols, or that of JAX while it traces a function to compile it.
"""

from __future__ import annotations

import operator
import sys
from collections.abc import Callable
from functools import cache, reduce
from types import SimpleNamespace
from typing import Any, Protocol, TypeVar, cast

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]
Float32Array = npt.NDArray[np.float32]
Flags = npt.NDArray[np.bool_]
Rows = np.ndarray[tuple[int], np.dtype[np.intp]]  # places in a leading axis

State = TypeVar("State", bound=tuple[npt.NDArray[Any], ...])
Unary = Callable[[Array], Array]
Binary = Callable[[Array, Array], Array]
Bounding = Callable[[Array | float, Array | float], Array]


class LinearAlgebra(Protocol):
    """What is used of a namespace's linear algebra."""

    solve: Binary
    pinv: Unary
    norm: Callable[..., Array]
    svd: Callable[..., tuple[Array, Array, Array]]


class Namespace(Protocol):
    """The functions of arrays that numpy and JAX both have, under numpy's names, as far as they are used."""

    linalg: LinearAlgebra
    sqrt: Unary
    sin: Unary
    cos: Unary
    abs: Unary
    arctan2: Binary
    hypot: Binary
    copysign: Binary
    maximum: Bounding
    minimum: Bounding
    where: Callable[[Flags, Array | float, Array | float], Array]
    any: Callable[[Flags], Flags]
    argmin: Callable[..., Rows]
    ones_like: Unary
    zeros_like: Unary
    broadcast_to: Callable[[Array, tuple[int, ...]], Array]
    concatenate: Callable[..., Array]
    stack: Callable[..., Array]
    pad: Callable[..., Array]
    swapaxes: Callable[[Array, int, int], Array]
    take: Callable[..., Array]
    take_along_axis: Callable[..., Array]
    vecdot: Binary
    vecmat: Binary
    matvec: Binary
    einsum: Callable[..., Array]


NUMPY = cast(Namespace, np)
OF_NUMPY = (np.ndarray, np.generic)
LIKE_NUMPY = (*OF_NUMPY, np.lib.mixins.NDArrayOperatorsMixin)  # what numpy's functions take
WRITTEN_OUT = 16  # terms of a sum


def namespace(array: npt.NDArray[Any]) -> Namespace:
    """The functions for arrays of this kind."""
    return NUMPY if type(array) is np.ndarray or isinstance(array, LIKE_NUMPY) else _of_jax()


@cache
def _of_jax() -> Namespace:
    """Those of JAX; products of small matrices and vectors are written out as sums, which are compiled into one with
    what stands around them, as a call of a library is not."""
    of_jax = SimpleNamespace(**vars(sys.modules["jax.numpy"]))
    of_jax.matmul = product
    of_jax.matvec = lambda a, b: product(a, b[..., None])[..., 0]
    of_jax.vecmat = lambda a, b: product(a[..., None, :], b)[..., 0, :]
    of_jax.vecdot = lambda a, b: product(a[..., None, :], b[..., None])[..., 0, 0]
    return cast(Namespace, of_jax)


def product(a: Array, b: Array) -> Array:
    """A B over the last two axes, or of a vector A or B, as ``@`` has it."""
    if type(a) is type(b) is np.ndarray or (isinstance(a, LIKE_NUMPY) and isinstance(b, LIKE_NUMPY)):
        whole: Array = np.matmul(a, b)
        return whole
    terms = a.shape[-1]
    if terms > WRITTEN_OUT:
        return a @ b
    if b.ndim == 1:
        return _sum([a[..., i] * b[i] for i in range(terms)])
    if a.ndim == 1:
        return _sum([a[i] * b[..., i, :] for i in range(terms)])
    return _sum([a[..., :, i, None] * b[..., None, i, :] for i in range(terms)])


def solved(definite: Array, right: Array) -> Array:
    """A⁻¹ B for a symmetric, positive definite A (..., n, n) and B (..., n, m); arrays may have a way of their own."""
    own: Binary | None = getattr(type(definite), "solved", None)
    return namespace(definite).linalg.solve(definite, right) if own is None else own(definite, right)


def _sum(terms: list[Array]) -> Array:
    return reduce(operator.add, terms)


def packed(*parts: Array) -> Array:
    """Components (...) each, side by side along a new last axis; the first has the shape of all."""
    first = parts[0]
    if not isinstance(first, OF_NUMPY):
        xp = namespace(first)
        return xp.stack([xp.broadcast_to(part, first.shape) for part in parts], axis=-1)
    whole = np.empty((*first.shape, len(parts)))
    for place, part in enumerate(parts):
        whole[..., place] = part
    return whole


def repeated(
    state: State,
    unfinished: Callable[..., Flags],
    step: Callable[..., State],
    most: int,
) -> State:
    """A state after as many steps as it takes until nothing of it is unfinished, ``most`` of them at most; both
    functions take the parts of a state."""
    if isinstance(state[0], LIKE_NUMPY):
        for _ in range(most):
            if not np.any(unfinished(*state)):
                break
            state = step(*state)
        return state
    from jax.lax import while_loop

    def goes_on(counted: Any) -> Any:
        return (counted[0] < most) & unfinished(*counted[1]).any()

    result: State = while_loop(goes_on, lambda counted: (counted[0] + 1, step(*counted[1])), (0, state))[1]
    return result
