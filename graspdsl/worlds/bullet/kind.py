"""The bullet world as an entry of the table of worlds; the engine is loaded where a world is made."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, ClassVar

from graspdsl.worlds.bullet.engine import EFFORT, INSTALLED_BY
from graspdsl.worlds.kind import Effort
from graspdsl.worlds.rigid.engine import Engine
from graspdsl.worlds.rigid.kind import RigidBodies


class Bullet(RigidBodies):
    """Rigid bodies under gravity, by PyBullet."""

    name = "bullet"
    about = "rigid bodies under gravity, soft fingertips on load cells (PyBullet)"

    effort = EFFORT
    libraries: ClassVar[Mapping[str, str]] = {"pybullet": INSTALLED_BY}

    def engine(self, effort: Effort) -> Engine[Any]:
        """PyBullet."""
        from graspdsl.worlds.bullet.stages import BulletEngine

        return BulletEngine(effort)
