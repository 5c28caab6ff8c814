"""What all worlds of rigid bodies have in common as entries of the table of worlds."""

from __future__ import annotations

from abc import abstractmethod
from typing import Any, ClassVar

from graspdsl.basis.spaces import GradientSpace
from graspdsl.worlds.kind import Effort, TrialStudio, View, WorldKind, WorldSettings
from graspdsl.worlds.protocol import WitnessedWorld
from graspdsl.worlds.rigid.engine import CONTROL_RATE, Engine
from graspdsl.worlds.touch.sensors import TACTILE_SENSORS


class RigidBodies(WorldKind):
    """A hand with soft fingertips and an object under gravity, in some engine."""

    rate = CONTROL_RATE
    together = 8  # a fifth quicker; those of more are lost, and to be run again, if a worker is killed
    sliding = frozenset({GradientSpace.JOINTS})
    probing = frozenset({GradientSpace.JOINTS, GradientSpace.SURFACE, GradientSpace.CARTESIAN})

    effort: ClassVar[Effort]

    @abstractmethod
    def engine(self, effort: Effort) -> Engine[Any]:
        """The engine, which is loaded now."""

    @property
    def senses(self) -> tuple[str, ...]:
        """All of the table."""
        return tuple(TACTILE_SENSORS)

    def make(self, settings: WorldSettings) -> WitnessedWorld:
        """The world in which joints are commanded, or contacts probed."""
        from graspdsl.worlds.rigid.world import RigidWorld

        return RigidWorld(self.engine((settings.effort or self.effort).whole(self.rate)), settings)

    def studio(self, view: View) -> TrialStudio:
        """Hand and object, drawn the same whatever engine moved them."""
        from graspdsl.worlds.mujoco.studio import GraspStudio

        return GraspStudio(view)
