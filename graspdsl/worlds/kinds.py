"""The table of worlds."""

from __future__ import annotations

from graspdsl.diagnostics import Diagnostic, listed
from graspdsl.worlds.bullet.kind import Bullet
from graspdsl.worlds.floating import Floating
from graspdsl.worlds.kind import Ability, WorldKind
from graspdsl.worlds.mujoco.kind import Mujoco
from graspdsl.worlds.rigid.kind import RigidBodies

WORLDS: dict[str, WorldKind] = {kind.name: kind for kind in (Bullet(), Mujoco(), Floating())}


def absence(kind: WorldKind) -> Diagnostic | None:
    """What there is to say of a world whose libraries are not installed; None where they are."""
    if not kind.missing:
        return None
    others = [name for name, other in WORLDS.items() if other.has("hand") == kind.has("hand") and not other.missing]
    ways = "; ".join(kind.libraries[name] for name in kind.missing)
    hint = f"{ways}; or use world: {listed(others, 'or')}" if others else ways
    return Diagnostic(
        "engine-missing", f"the {kind.name} world needs {listed(kind.missing)}, which this Python has not", hint=hint
    )


def rigid_bodies() -> RigidBodies:
    """The first world of rigid bodies whose libraries are installed."""
    return next(kind for kind in WORLDS.values() if isinstance(kind, RigidBodies) and not kind.missing)


def worlds_with(ability: Ability) -> str:
    """The worlds that have what others lack, as a hint names them: ``the bullet world``."""
    return f"the {listed([name for name, kind in WORLDS.items() if kind.has(ability)], 'or')} world"


def worlds_without(ability: Ability) -> str:
    """The worlds that lack something, as a hint names them."""
    return f"the {listed([name for name, kind in WORLDS.items() if not kind.has(ability)], 'or')} world"
