"""What a backend is, and numpy, which needs no compiler."""

from __future__ import annotations

import importlib.util
import operator
from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping
from typing import ClassVar

from graspdsl.arrays import Array

Step = Callable[..., Array]  # of arrays
Function = Callable[..., tuple[Array, ...]]  # of what it shall call its steps by, and of arrays
Batched = Callable[..., tuple[Array, ...]]  # of the shape of a batch, and of arrays that have it before their own


class Backend(ABC):
    """What evaluates functions of arrays that are written against their namespace.

    ``libraries``: distributions that it needs and its numbers depend on, with how they are installed. ``loops``:
    whether it gains by functions that are loops until something converges.
    """

    name: ClassVar[str]
    about: ClassVar[str]
    libraries: ClassVar[Mapping[str, str]] = {}
    loops: ClassVar[bool] = False

    @property
    def missing(self) -> tuple[str, ...]:
        """Those of its libraries that are not installed."""
        return tuple(name for name in self.libraries if importlib.util.find_spec(name) is None)

    @abstractmethod
    def compiled(self, function: Function) -> Batched:
        """What does the same to arrays of numpy, told first of all the shape of the trials side by side in each.

        The function is given what it shall call each of its steps by: ``call(step, *arrays)``.
        """

    @abstractmethod
    def refusal(self, step: Step, *arrays: Array) -> str:
        """Why it cannot evaluate a step, of arrays of these shapes; empty where it can."""


class Numpy(Backend):
    """Calls them."""

    name = "numpy"
    about = "each step by itself"

    def compiled(self, function: Function) -> Batched:
        """The function."""
        return lambda _, *arrays: function(operator.call, *arrays)

    def refusal(self, step: Step, *arrays: Array) -> str:
        """It can all."""
        del step, arrays
        return ""
