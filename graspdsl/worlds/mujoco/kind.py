"""The mujoco world as an entry of the table of worlds; the engine is loaded where a world is made."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, ClassVar

from graspdsl.worlds.kind import Effort
from graspdsl.worlds.mujoco.effort import EFFORT
from graspdsl.worlds.rigid.engine import Engine
from graspdsl.worlds.rigid.kind import RigidBodies


class Mujoco(RigidBodies):
    """Rigid bodies under gravity, by MuJoCo."""

    name = "mujoco"
    about = "the same by another engine, many times faster (MuJoCo)"

    effort = EFFORT
    together = 64
    libraries: ClassVar[Mapping[str, str]] = {"mujoco": "pip install mujoco"}

    def engine(self, effort: Effort) -> Engine[Any]:
        """MuJoCo."""
        from graspdsl.worlds.mujoco.stages import MujocoEngine

        return MujocoEngine(effort)
