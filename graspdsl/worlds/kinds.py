"""The table of worlds."""

from __future__ import annotations

from graspdsl.diagnostics import listed
from graspdsl.worlds.bullet.kind import Bullet
from graspdsl.worlds.floating import Floating
from graspdsl.worlds.kind import Ability, WorldKind

WORLDS: dict[str, WorldKind] = {kind.name: kind for kind in (Bullet(), Floating())}


def worlds_with(ability: Ability) -> str:
    """The worlds that have what others lack, as a hint names them: ``the bullet world``."""
    return f"the {listed([name for name, kind in WORLDS.items() if kind.has(ability)], 'or')} world"


def worlds_without(ability: Ability) -> str:
    """The worlds that lack something, as a hint names them."""
    return f"the {listed([name for name, kind in WORLDS.items() if not kind.has(ability)], 'or')} world"
