"""JAX, which compiles all steps as one for a CPU or a GPU."""

from __future__ import annotations

import importlib
import math
from collections.abc import Callable
from functools import cache, partial
from itertools import accumulate, pairwise
from typing import Any, ClassVar

import numpy as np

from graspdsl.arrays import Array
from graspdsl.backends.backend import Backend, Batched, Function, Step

FEW, SPARE = 64, 4  # rows that cost next to nothing, and how many times as many as there are trials a function is given


class Jax(Backend):
    """Compiles them by XLA, with numbers of 64 bits, at their first call for so many trials."""

    name = "jax"
    about = "all steps compiled as one"
    loops = True
    libraries: ClassVar = {"jax": "pip install 'graspdsl[jax]'", "jaxlib": "pip install 'graspdsl[jax]'"}

    def compiled(self, function: Function) -> Batched:
        """Compiled when it is first called."""
        return _Compiled(function)

    def refusal(self, step: Step, *arrays: Array) -> str:
        """What JAX says when it traces a step that is not written for its arrays."""
        jax = _jax()
        try:
            jax.eval_shape(partial(_call, step), *arrays)
        except (jax.errors.JAXTypeError, TypeError, AttributeError) as error:
            return str(error).partition("\n")[0]
        return ""


class _Compiled:
    """A function of one trial, compiled for one, and anew for each number of trials that is not near one before."""

    def __init__(self, function: Function) -> None:
        self._function = function
        self._rooms: list[int] = []

    def __call__(self, batch: tuple[int, ...], *arrays: Array) -> tuple[Array, ...]:
        inner = [array.shape[len(batch) :] for array in arrays]
        kinds = tuple((shape, array.dtype) for shape, array in zip(inner, arrays, strict=True))
        row, shapes = _jitted(self._function, kinds, bool(batch))
        if batch:
            count = math.prod(batch)
            room = self._room(count)
            arrays = tuple(
                _filled(array.reshape(count, *shape), room) for array, shape in zip(arrays, inner, strict=True)
            )
            rows = np.asarray(row(*arrays))[:count]
        else:
            rows = np.asarray(row(*arrays))
        ends = list(accumulate(map(math.prod, shapes), initial=0))
        parts = zip(pairwise(ends), shapes, strict=True)
        return tuple(rows[..., first:end].reshape((*batch, *shape)) for (first, end), shape in parts)

    def _room(self, count: int) -> int:
        """How many rows so many trials get: as before where trials have left, so that nothing is compiled for each."""
        fitting = [room for room in self._rooms if count <= room <= max(FEW, SPARE * count)]
        if not fitting:
            self._rooms.append(count)
        return min(fitting, default=count)


def _filled(array: Array, room: int) -> Array:
    """An array with its last row again and again up to so many rows."""
    if len(array) == room:
        return array
    return np.concatenate([array, np.broadcast_to(array[-1:], (room - len(array), *array.shape[1:]))])


@cache
def _jitted(
    function: Function, kinds: tuple[tuple[tuple[int, ...], Any], ...], batched: bool
) -> tuple[Callable[..., Array], tuple[tuple[int, ...], ...]]:
    """A function of arrays of these shapes and types, or of rows of them, that gives one array of all it makes, for to
    fetch an array takes longer than to compute a small one; and the shapes of these."""
    jax = _jax()

    def in_a_row(*arrays: Array) -> Array:
        row: Array = jax.numpy.concatenate([made.ravel() for made in function(_call, *arrays)])
        return row

    made = jax.eval_shape(partial(function, _call), *(jax.ShapeDtypeStruct(*kind) for kind in kinds))
    return jax.jit(jax.vmap(in_a_row) if batched else in_a_row), tuple(one.shape for one in made)


def _call(step: Step, *arrays: Array) -> Array:
    """What a step makes of arrays of JAX."""
    called: Array = _jax().numpy.asarray(_own(step)(*arrays))
    return called


def _own(step: Step) -> Step:
    """A ufunc of numpy becomes that of JAX; all others know what arrays they are given."""
    if isinstance(step, partial):
        return partial(_own(step.func), *step.args, **step.keywords)
    own: Step = getattr(_jax().numpy, step.__name__) if isinstance(step, np.ufunc) else step
    return own


@cache
def _jax() -> Any:
    """JAX, with numbers of 64 bits, and without a thread between a small function and its caller."""
    jax: Any = importlib.import_module("jax")
    jax.config.update("jax_enable_x64", True)
    jax.config.update("jax_cpu_enable_async_dispatch", False)
    return jax
