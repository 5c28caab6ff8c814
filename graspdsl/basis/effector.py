"""What an effector transform τ is: the Jacobian of what is sensed with respect to what is moved (Eq. 3.5, 4.33)."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import ClassVar

from graspdsl.arrays import Array
from graspdsl.basis.spaces import GradientSpace


class Effector(ABC):
    """An effector transform: ``reads`` names its inputs, fields of an Observation or what the compiler makes of them.

    On the surface the k contacts move by (2k,) coordinates, in Cartesian space by a (3k,) displacement; in rotation
    space all turn as one, by (3,) exponential coordinates; in joint space the n joints move.
    """

    symbol: ClassVar[str]
    about: ClassVar[str]
    equation: ClassVar[str]
    gradient_space: ClassVar[GradientSpace]
    reads: ClassVar[tuple[str, ...]]

    @abstractmethod
    def evaluate(self, mixing: Array, *inputs: Array) -> Array:
        """τ, (..., d, D): rows of the task space, columns of the gradient space.

        mixing: (m, k) in joint space, (s, n) for joint sets; in rotation space (2, k), the weights in Γσ of the points
        and of the normals that turn; weights (k,) otherwise.
        """
