"""What evaluates the functions of a tick: numpy as they stand, or what compiles them."""

from graspdsl.backends.backend import Backend, Numpy
from graspdsl.backends.of_casadi import CasADi
from graspdsl.backends.of_jax import Jax

BACKENDS: dict[str, Backend] = {backend.name: backend for backend in (Numpy(), Jax(), CasADi())}
NUMPY = BACKENDS[Numpy.name]

__all__ = ["BACKENDS", "NUMPY", "Backend"]
