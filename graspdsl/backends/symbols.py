"""Arrays of numbers that are not known yet: what is done with them by numpy's functions is written down.

A function of arrays that is called with them, whether it asks for a namespace or uses numpy as it stands, gives the
formula of each of its elements. What a formula cannot be made of, a comparison that decides what is run, a
decomposition of a matrix, raises TypeError.
"""

from __future__ import annotations

import importlib
import math
import operator
from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import cache, partial, reduce
from itertools import accumulate
from typing import Any

import numpy as np
import numpy.typing as npt

from graspdsl.arrays import Array

LARGEST = 4096  # numbers of an array, those that a product adds up among them: what has more takes a library less time
ANY = slice(None)


class Symbols(np.lib.mixins.NDArrayOperatorsMixin):
    """An array of formulas, a view of a ``column`` of CasADi: the places (...) there of its elements, and the type that
    these will have."""

    def __init__(self, column: Any, places: npt.NDArray[np.intp] | None = None, dtype: npt.DTypeLike = float) -> None:
        self.column = column
        self.places = np.arange(column.numel()) if places is None else places
        self.dtype = np.dtype(dtype)

    @property
    def shape(self) -> tuple[int, ...]:
        """As of any array."""
        return self.places.shape

    @property
    def ndim(self) -> int:
        """The number of axes."""
        return self.places.ndim

    @property
    def size(self) -> int:
        """The number of elements."""
        return self.places.size

    @property
    def elements(self) -> Any:
        """Its elements in order, as a column of its own."""
        if self.size == self.column.numel() and (self.places.ravel() == np.arange(self.size)).all():
            return self.column
        return self.column.nz[self.places.ravel().tolist()]

    def at(self, places: npt.NDArray[np.intp]) -> Symbols:
        """What is at other places of the column."""
        return Symbols(self.column, places, self.dtype)

    def reshape(self, *shape: Any) -> Symbols:
        """The same elements in another shape."""
        return self.at(self.places.reshape(*shape))

    def astype(self, dtype: npt.DTypeLike) -> Symbols:
        """The same numbers, truth values as zeros and ones."""
        if np.dtype(dtype) != np.float64:
            raise TypeError(f"numbers that are not known yet cannot become {dtype}")
        return Symbols(self.column, self.places)

    def solved(self, right: Any) -> Symbols:
        """A⁻¹ B (n, m) of a symmetric, positive definite one (n, n) and B (n, m), by L D Lᵀ."""
        (count, _), (_, columns) = self.shape, np.shape(right)
        to = casadi()  # whose columns come one after the other
        factors = to.ldl(to.reshape(self.T.elements, count, count))
        result = to.ldl_solve(to.reshape(_column(np.transpose(right)), count, columns), *factors)
        return Symbols(to.vec(result), np.arange(right.size).reshape(columns, count).T)

    def __len__(self) -> int:
        return len(self.places)

    def __iter__(self) -> Iterator[Symbols]:
        return (self[place] for place in range(len(self)))

    def __getitem__(self, key: Any) -> Symbols:
        return self.at(np.asarray(self.places[key]))

    def __getattr__(self, name: str) -> Any:
        if name == "T":
            return self.at(self.places.T)
        function: Any = getattr(np, name, None)
        if function in MOVES or function in FUNCTIONS:
            return partial(function, self)
        raise AttributeError(f"arrays of numbers that are not known yet have no {name}")

    def __bool__(self) -> bool:
        raise TypeError("whether something is so is not known yet")

    def __array__(self, *given: object, **options: object) -> Array:
        raise TypeError("the numbers of an array are not known yet")

    def __array_ufunc__(self, ufunc: np.ufunc, method: str, *inputs: Any, **options: Any) -> Any:
        if method == "reduce":
            return _reduced(ufunc, *inputs, **options)
        if method != "__call__" or options:
            return NotImplemented
        if ufunc in PRODUCTS:
            return PRODUCTS[ufunc](*inputs)
        return _each(ufunc, *inputs) if ufunc in _formulas() else NotImplemented

    def __array_function__(
        self, function: Callable[..., Any], types: object, given: Sequence[Any], options: Mapping[str, Any]
    ) -> Any:
        first, *others = given
        if function in MOVES and isinstance(first, Symbols):
            return first.at(function(first.places, *others, **options))
        return FUNCTIONS[function](*given, **options) if function in FUNCTIONS else NotImplemented


SAME = (
    *("sqrt", "exp", "expm1", "log", "log1p", "log10", "sin", "cos", "tan", "arcsin", "arccos", "arctan", "arctan2"),
    *("sinh", "cosh", "tanh", "arcsinh", "arccosh", "arctanh", "hypot", "copysign", "sign", "floor", "ceil", "fmod"),
    "power",
)
LOGIC: dict[np.ufunc, str] = {
    np.less: "lt",
    np.less_equal: "le",
    np.greater: "gt",
    np.greater_equal: "ge",
    np.equal: "eq",
    np.not_equal: "ne",
    np.logical_and: "logic_and",
    np.logical_or: "logic_or",
    np.logical_not: "logic_not",
}
BITWISE: dict[np.ufunc, str] = {np.bitwise_and: "logic_and", np.bitwise_or: "logic_or", np.invert: "logic_not"}


@cache
def casadi() -> Any:
    """CasADi, which takes its time to load."""
    return importlib.import_module("casadi")


@cache
def _formulas() -> Mapping[np.ufunc, Callable[..., Any]]:
    """What CasADi has for the functions of numpy that work element by element."""
    to = casadi()
    return {
        np.add: to.plus,
        np.subtract: to.minus,
        np.multiply: to.times,
        np.divide: to.rdivide,
        np.negative: operator.neg,
        np.absolute: to.fabs,
        np.square: lambda x: x * x,
        np.maximum: to.fmax,
        np.minimum: to.fmin,
        np.rint: lambda x: x - to.remainder(x, 1.0),
        **{getattr(np, name): getattr(to, name) for name in SAME},
        **{ufunc: getattr(to, name) for ufunc, name in (LOGIC | BITWISE).items()},
    }


def _each(ufunc: np.ufunc, *arrays: Any) -> Symbols:
    """A function of numpy, element by element."""
    truths = all(_type(array) == np.bool_ for array in arrays)
    if truths != (ufunc in BITWISE) and ufunc not in LOGIC:
        raise TypeError(f"{ufunc.__name__} of {'truth values' if truths else 'numbers'}")
    shape, made = np.broadcast_shapes(*map(np.shape, arrays)), bool if ufunc in LOGIC or ufunc in BITWISE else float
    return _in_shape(_formulas()[ufunc](*_alike(shape, arrays)), shape, made)


def _type(array: Any) -> np.dtype[Any]:
    return array.dtype if isinstance(array, Symbols) else np.asarray(array).dtype


def in_formulas(array: Any) -> Symbols:
    """An array as symbols, also one whose numbers are known."""
    return array if isinstance(array, Symbols) else _in_shape(_column(array), np.shape(array), np.asarray(array).dtype)


def _in_shape(column: Any, shape: tuple[int, ...], dtype: npt.DTypeLike = float) -> Symbols:
    return Symbols(column, np.arange(column.numel()).reshape(shape), dtype)


def _alike(shape: tuple[int, ...], arrays: Sequence[Any]) -> list[Any]:
    """The elements of arrays in a shape, as columns; of what is one number, that."""
    if math.prod(shape) > LARGEST:
        raise TypeError(f"{math.prod(shape)} elements")
    return [_column(array if np.size(array) == 1 else np.broadcast_to(array, shape)) for array in arrays]


def _column(array: Any) -> Any:
    """The elements of an array."""
    if isinstance(array, Symbols):
        return array.elements
    return casadi().SX(np.asarray(array, dtype=np.float64).ravel())


def _reduced(
    ufunc: np.ufunc, array: Any, axis: int | tuple[int, ...] | None = None, *, keepdims: bool = False, **usual: object
) -> Any:
    """A function of two numbers, of all along an axis."""
    if usual.get("dtype") is not None or usual.get("where", True) is not True or usual.keys() & {"initial", "out"}:
        raise TypeError(f"{ufunc.__name__} with options")
    axes = range(array.ndim) if axis is None else np.atleast_1d(axis) % array.ndim
    rest = array if array.dtype == np.bool_ or ufunc not in LOGIC else array != 0.0
    if rest.dtype == np.bool_ and ufunc not in LOGIC:
        raise TypeError(f"{ufunc.__name__} of truth values")
    for place in sorted(axes, reverse=True):
        rest = reduce(ufunc, np.moveaxis(rest, place, 0))
    kept = tuple(1 if place in axes else length for place, length in enumerate(array.shape))
    return rest.reshape(kept) if keepdims else rest


def _mean(array: Any, axis: int | None = None, *, keepdims: bool = False) -> Any:
    return np.sum(array, axis=axis, keepdims=keepdims) / (array.size if axis is None else array.shape[axis])


def _matmul(a: Any, b: Any) -> Any:
    """A B over the last two axes, or of a vector A or B."""
    if np.ndim(a) == 1:
        return _matmul(a[None, :], b)[..., 0, :]
    if np.ndim(b) == 1:
        return _matmul(a, b[:, None])[..., 0]
    return np.sum(a[..., :, None] * b[..., None, :, :], axis=-2)


PRODUCTS: dict[np.ufunc, Callable[[Any, Any], Any]] = {
    np.matmul: _matmul,
    np.matvec: lambda matrix, vector: np.sum(matrix * vector[..., None, :], axis=-1),
    np.vecmat: lambda vector, matrix: np.sum(vector[..., :, None] * matrix, axis=-2),
    np.vecdot: lambda a, b: np.sum(a * b, axis=-1),
}


def _einsum(subscripts: str, *arrays: Any) -> Any:
    """As numpy's, of what names its result and no axis of an array twice."""
    terms, arrow, result = subscripts.replace(" ", "").partition("->")
    if not arrow:
        raise TypeError(f"einsum of {subscripts}, which does not name its result")
    named = [term.replace("...", "") for term in terms.split(",")]
    ahead = [np.ndim(array) - len(term) for array, term in zip(arrays, named, strict=True)]
    letters = sorted(set("".join(named)))
    spread = []
    for array, term, before in zip(arrays, named, ahead, strict=True):
        order = [term.index(letter) + before for letter in letters if letter in term]
        moved = np.transpose(array, [*range(before), *order])
        spread.append(moved[(..., *(ANY if letter in term else None for letter in letters))])
    whole = reduce(np.multiply, spread)
    summed = tuple(place - len(letters) for place, letter in enumerate(letters) if letter not in result)
    whole, left = np.sum(whole, axis=summed) if summed else whole, [letter for letter in letters if letter in result]
    before = whole.ndim - len(left)
    wanted = result.replace("...", "")
    return np.transpose(whole, [*range(before), *(before + left.index(letter) for letter in wanted)])


def _where(condition: Any, one: Any, other: Any) -> Symbols:
    shape = np.broadcast_shapes(np.shape(condition), np.shape(one), np.shape(other))
    made = bool if _type(one) == _type(other) == np.bool_ else float
    if isinstance(condition, Symbols):
        return _in_shape(casadi().if_else(*_alike(shape, (condition, one, other))), shape, made)
    both = _stack([np.broadcast_to(one, shape), np.broadcast_to(other, shape)])
    return both.at(np.where(condition, both.places[0], both.places[1]))


def _concatenate(arrays: Sequence[Any], axis: int = 0) -> Symbols:
    starts = accumulate((np.size(array) for array in arrays[:-1]), initial=0)
    places = [
        np.arange(start, start + np.size(array)).reshape(np.shape(array))
        for array, start in zip(arrays, starts, strict=True)
    ]
    made = bool if all(_type(array) == np.bool_ for array in arrays) else float
    return Symbols(casadi().vertcat(*map(_column, arrays)), np.concatenate(places, axis), made)


def _stack(arrays: Sequence[Any], axis: int = 0) -> Symbols:
    return _concatenate([np.expand_dims(array, axis) for array in arrays], axis)


def _pad(array: Symbols, widths: Any) -> Symbols:
    return Symbols(casadi().vertcat(0.0, array.column), np.pad(array.places + 1, widths), array.dtype)


def _first(ahead: np.ufunc, array: Any, axis: int) -> Symbols:
    """Where along an axis the first element is that no other is ahead of."""
    best, *others = np.moveaxis(array, axis, 0)
    place = best * 0.0
    for number, other in enumerate(others, start=1):
        better = ahead(other, best)
        best, place = np.where(better, other, best), np.where(better, float(number), place)
    return Symbols(place.column, place.places, np.intp)


def _take_along_axis(array: Any, place: Any, axis: int) -> Any:
    if place.shape[axis] != 1:
        raise TypeError("more than one of each row")
    shape = np.ones(array.ndim, dtype=int)
    shape[axis] = -1
    return np.sum(
        np.where(np.equal(place, np.arange(array.shape[axis]).reshape(shape)), array, 0.0), axis=axis, keepdims=True
    )


def _trace(array: Any, offset: int = 0, axis1: int = 0, axis2: int = 1) -> Any:
    return np.sum(np.diagonal(array, offset, axis1, axis2), axis=-1)


def _norm(array: Any, *, axis: int | None = None, keepdims: bool = False) -> Any:
    return np.sqrt(np.sum(array * array, axis=axis, keepdims=keepdims))


MOVES: set[object] = {
    *(np.reshape, np.ravel, np.transpose, np.swapaxes, np.moveaxis, np.expand_dims, np.squeeze, np.broadcast_to),
    *(np.diagonal, np.take, np.repeat, np.tile, np.roll, np.flip, np.copy),
}
FUNCTIONS: dict[object, Callable[..., Any]] = {
    np.shape: lambda array: array.shape,
    np.ndim: lambda array: array.ndim,
    np.size: lambda array: array.size,
    np.where: _where,
    np.concatenate: _concatenate,
    np.stack: _stack,
    np.pad: _pad,
    np.zeros_like: lambda array: array * 0.0,
    np.ones_like: lambda array: array * 0.0 + 1.0,
    np.sum: partial(_reduced, np.add),
    np.max: partial(_reduced, np.maximum),
    np.min: partial(_reduced, np.minimum),
    np.any: partial(_reduced, np.logical_or),
    np.all: partial(_reduced, np.logical_and),
    np.mean: _mean,
    np.argmax: partial(_first, np.greater),
    np.argmin: partial(_first, np.less),
    np.take_along_axis: _take_along_axis,
    np.round: np.rint,
    np.trace: _trace,
    np.einsum: _einsum,
    np.linalg.norm: _norm,
}
