"""The ways to work out a spec's physics that should not matter: engines, time steps and efforts of their solvers."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from graspdsl.spec.scene import MOST_ITERATIONS, TIME_STEPS
from graspdsl.worlds.kind import Effort
from graspdsl.worlds.kinds import WORLDS


@dataclass(frozen=True, slots=True)
class Variant:
    """One way: its world, and its ``effort``; ``name``: its folder's. ``measure``: the place among others of the one
    that it is held against, itself for the first. ``settings``: as ``--set`` takes them."""

    name: str
    label: str
    world: str
    effort: Effort
    measure: int
    settings: tuple[str, ...]


def worlds_to_vary() -> list[str]:
    """The worlds whose physics can be varied, and whose libraries are installed."""
    return [name for name, kind in WORLDS.items() if kind.effort is not None and not kind.missing]


def variants(worlds: Sequence[tuple[str, Effort]], *, finer: bool = True) -> list[Variant]:
    """Each world as it is, held against the first; then, where ``finer``, each at half and at twice its time step and
    its iterations, held against itself. What a spec may not ask for is left out."""
    made = [Variant(world, world, world, effort, 0, (f"scene.world={world}",)) for world, effort in worlds]
    for place, plain in enumerate(made[:]):
        for what, effort in _other_efforts(plain.effort) if finer else ():
            if _can_be(effort, WORLDS[plain.world].rate):
                made.append(_varied(plain, place, what, effort))
    return made


def _can_be(effort: Effort, rate: float) -> bool:
    """Whether a spec may ask for it."""
    shortest, longest = TIME_STEPS
    is_known = shortest <= effort.time_step <= longest and 1 <= effort.solver_iterations <= MOST_ITERATIONS
    return is_known and effort.divides(rate)


def _other_efforts(effort: Effort) -> Iterator[tuple[str, Effort]]:
    step, iterations = effort.time_step, effort.solver_iterations
    yield "half time step", Effort(step / 2, iterations)
    yield "double time step", Effort(step * 2, iterations)
    yield "half solver effort", Effort(step, iterations // 2)
    yield "double solver effort", Effort(step, iterations * 2)


def _varied(plain: Variant, place: int, what: str, effort: Effort) -> Variant:
    keys = ("time_step", "solver_iterations")
    changed = [(key, getattr(effort, key)) for key in keys if getattr(effort, key) != getattr(plain.effort, key)]
    settings = tuple(f"scene.physics.{key}={value:g}" for key, value in changed)
    name = f"{plain.name}-{what.replace(' ', '-')}"
    return Variant(name, f"{plain.label}, {what}", plain.world, effort, place, (*plain.settings, *settings))
