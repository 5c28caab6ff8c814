"""What each kind of world can do, known without starting it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from graspdsl.basis.spaces import GradientSpace


@dataclass(frozen=True, slots=True)
class WorldKind:
    """A kind of world: its tick rate [Hz], the gradient spaces it can carry out, sliding and probing.

    ``floats``: its contacts have no hand, no load cells and no forces. ``together``: how many trials it runs side by
    side.
    """

    name: str
    about: str
    rate: float
    sliding: frozenset[GradientSpace]
    probing: frozenset[GradientSpace]
    floats: bool = False
    together: int = 1

    def spaces(self, displacement: str) -> frozenset[GradientSpace]:
        """The gradient spaces of a way to displace contacts, ``sliding`` or ``probing``."""
        return self.probing if displacement == "probing" else self.sliding


WORLDS: Mapping[str, WorldKind] = {
    "bullet": WorldKind(
        "bullet",
        "rigid bodies under gravity, soft fingertips on load cells (PyBullet)",
        50.0,
        sliding=frozenset({GradientSpace.JOINTS}),
        probing=frozenset({GradientSpace.JOINTS, GradientSpace.SURFACE, GradientSpace.CARTESIAN}),
    ),
    "floating": WorldKind(
        "floating",
        "frictionless contacts on a known surface, no hand and no physics",
        50.0,
        sliding=frozenset({GradientSpace.SURFACE, GradientSpace.CARTESIAN}),
        probing=frozenset({GradientSpace.SURFACE, GradientSpace.CARTESIAN}),
        floats=True,
        together=64,
    ),
}
