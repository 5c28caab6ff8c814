"""PyBullet as an engine of rigid bodies: its stages, one or several side by side."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from graspdsl.arrays import Array
from graspdsl.objects.shapes import Body
from graspdsl.worlds.bullet.engine import EFFORT
from graspdsl.worlds.bullet.stage import BulletStage
from graspdsl.worlds.kind import Anchor, Effort, WorldSettings
from graspdsl.worlds.rigid.engine import Stages, Touched
from graspdsl.worlds.touch.fingertip_sensor import TipFrames


class BulletEngine:
    """PyBullet."""

    def __init__(self, effort: Effort = EFFORT) -> None:
        self._effort = effort

    @property
    def time_step(self) -> float:
        """Of a step [s]."""
        return self._effort.time_step

    def stage(self, settings: WorldSettings, position: Array, quaternion: Array) -> BulletStage:
        """Object, table and robot."""
        stage = BulletStage(self._effort, settings.body, settings.table_friction, settings.gravity, settings.anchor)
        stage.put_hand(settings, position, quaternion)
        return stage

    def side_by_side(self, stages: Sequence[BulletStage]) -> BulletStages:
        """Each by itself."""
        return BulletStages(stages)

    def table(self, body: Body, table_friction: float, gravity: float) -> BulletStage:
        """An object on the table."""
        return BulletStage(self._effort, body, table_friction, gravity, Anchor.NONE)

    def close(self) -> None:
        """Nothing is kept: the engine's own reset would not give the same numbers again."""


class BulletStages(Stages):
    """Stages that are asked one after the other."""

    def __init__(self, stages: Sequence[BulletStage]) -> None:
        self._stages: Sequence[BulletStage] = stages

    def tip_frames(self) -> TipFrames:
        """The frames of the fingertips' links, in the world."""
        frames = [tuple(zip(*stage.hand.tip_frames(), strict=True)) for stage in self._stages]
        return TipFrames(*(np.array(part) for part in zip(*frames, strict=True)))

    def tip_jacobians(self, frames: TipFrames, places: Array) -> Array:
        """Linear and angular Jacobians (2, N, k, 3, n) of points (N, k, 3) in the frames of the fingertips' links."""
        del frames
        found = [stage.hand.tip_jacobians(place) for stage, place in zip(self._stages, places, strict=True)]
        return np.array(found).swapaxes(0, 1)

    def touched(self) -> Touched:
        """What touches what."""
        stages = self._stages
        points, normals, forces = np.array([stage.fingertips.contacts() for stage in stages]).swapaxes(0, 1)
        presses = [[pressed.sum() for _, pressed in stage.fingertips.presses()] for stage in stages]
        other_links = tuple(stage.scene.other_links(stage.hand) for stage in stages)
        table_links = tuple(stage.scene.table_links(stage.hand) for stage in stages)
        return Touched(points, normals, forces, np.array(presses), other_links, table_links)

    def loads(self) -> Array:
        """What PARTIES put on the objects, (N, 4, 6), but for the engine's own damping."""
        return np.array([stage.scene.loads(stage.hand, stage.gravity, stage.time_step) for stage in self._stages])
