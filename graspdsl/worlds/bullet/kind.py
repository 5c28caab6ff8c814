"""The bullet world as an entry of the table of worlds; the engine is loaded where a world is made."""

from __future__ import annotations

from graspdsl.basis.spaces import GradientSpace
from graspdsl.worlds.bullet.engine import CONTROL_RATE
from graspdsl.worlds.kind import TrialStudio, View, WorldKind, WorldSettings
from graspdsl.worlds.protocol import WitnessedWorld
from graspdsl.worlds.touch.sensors import TACTILE_SENSORS


class Bullet(WorldKind):
    """Rigid bodies under gravity, by PyBullet."""

    name = "bullet"
    about = "rigid bodies under gravity, soft fingertips on load cells (PyBullet)"
    rate = CONTROL_RATE
    sliding = frozenset({GradientSpace.JOINTS})
    probing = frozenset({GradientSpace.JOINTS, GradientSpace.SURFACE, GradientSpace.CARTESIAN})

    @property
    def senses(self) -> tuple[str, ...]:
        """All of the table."""
        return tuple(TACTILE_SENSORS)

    def make(self, settings: WorldSettings) -> WitnessedWorld:
        """The world in which joints are commanded, or contacts probed."""
        from graspdsl.worlds.bullet.probing import ProbingWorld
        from graspdsl.worlds.bullet.world import BulletWorld

        return ProbingWorld(settings) if settings.probes else BulletWorld(settings)

    def studio(self, view: View) -> TrialStudio:
        """Hand and object."""
        from graspdsl.worlds.bullet.replay import GraspStudio

        assert view.start is not None
        return GraspStudio(view.settings, view.start, view.grasp, window=view.window)
