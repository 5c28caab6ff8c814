"""What each kind of world can do, known without starting it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from graspdsl.basis.spaces import GradientSpace


@dataclass(frozen=True, slots=True)
class WorldKind:
    """A kind of world: its tick rate [Hz] and the gradient spaces it can carry out."""

    name: str
    about: str
    rate: float
    spaces: frozenset[GradientSpace]


WORLDS: Mapping[str, WorldKind] = {
    "bullet": WorldKind(
        "bullet",
        "rigid bodies under gravity, soft fingertips on load cells (PyBullet)",
        50.0,
        frozenset({GradientSpace.JOINTS}),
    ),
}
