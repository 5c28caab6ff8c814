"""MuJoCo as an engine of rigid bodies: its stages; what is read of several is worked out for all at once."""

from __future__ import annotations

import copy
from collections.abc import Sequence

import mujoco
import numpy as np

from graspdsl.arrays import Array
from graspdsl.basis.algebra import cross
from graspdsl.objects.shapes import Body
from graspdsl.worlds.kind import Anchor, Effort, WorldSettings
from graspdsl.worlds.mujoco.model import TipBody, part_overlapping, robot_spec, scene_spec
from graspdsl.worlds.mujoco.stage import MujocoStage
from graspdsl.worlds.mujoco.touches import Touches
from graspdsl.worlds.protocol import PARTIES
from graspdsl.worlds.rigid.engine import Stages, Touched
from graspdsl.worlds.touch.fingertip_sensor import TipFrames


class MujocoEngine:
    """MuJoCo. A model is compiled once for a world, and each stage is one of its states."""

    def __init__(self, effort: Effort) -> None:
        self._effort = effort
        self._built: tuple[WorldSettings, mujoco.MjModel, list[TipBody]] | None = None

    @property
    def time_step(self) -> float:
        """Of a step [s]."""
        return self._effort.time_step

    def stage(self, settings: WorldSettings, position: Array, quaternion: Array) -> MujocoStage:
        """Object, table and robot."""
        if self._built is None or self._built[0] is not settings:
            spec, tips = robot_spec(settings)
            model = self._compiled(spec)
            self._built = settings, self._compiled(spec) if part_overlapping(spec, model) else model, tips
        _, model, tips = self._built
        stage = MujocoStage(copy.copy(model), settings.body, settings.gravity)
        stage.put_hand(settings, tips, position, quaternion)
        return stage

    def side_by_side(self, stages: Sequence[MujocoStage]) -> MujocoStages:
        """All at once."""
        return MujocoStages(stages)

    def table(self, body: Body, table_friction: float, gravity: float) -> MujocoStage:
        """An object on the table."""
        return MujocoStage(self._compiled(scene_spec(body, table_friction, gravity, Anchor.NONE)), body, gravity)

    def _compiled(self, spec: mujoco.MjSpec) -> mujoco.MjModel:
        spec.option.timestep, spec.option.iterations = self._effort.time_step, self._effort.solver_iterations
        return spec.compile()

    def close(self) -> None:
        """Forget the model."""
        self._built = None


class MujocoStages(Stages):
    """Stages of one model."""

    def __init__(self, stages: Sequence[MujocoStage]) -> None:
        self._stages: Sequence[MujocoStage] = stages

    def tip_frames(self) -> TipFrames:
        """The frames of the fingertips' links, in the world."""
        origins, rotations = zip(*(stage.hand.tip_frames() for stage in self._stages), strict=True)
        return TipFrames(np.array(origins), np.array(rotations))

    def tip_jacobians(self, frames: TipFrames, places: Array) -> Array:
        """Linear and angular Jacobians (2, N, k, 3, n) of points (N, k, 3) in the frames of the fingertips' links."""
        hand = self._stages[0].hand
        points = frames.origins + np.matvec(frames.rotations, places)
        found = np.zeros((2, *points.shape, self._stages[0].state.model.nv))
        for stage, *of_stage in zip(self._stages, points, *found, strict=True):
            stage.hand.note_jacobians(*of_stage)
        return hand.by_joints(found)

    def touched(self) -> Touched:
        """What touches what."""
        first = self._stages[0]
        found = Touches([stage.state for stage in self._stages], first.hand, first.scene)
        is_table = np.arange(len(first.scene.is_mine)) == first.table
        tips = {first.hand.link_of[geom] for geom in first.hand.tip_geoms}
        other_links = tuple(tuple(sorted(links - tips)) for links in found.links(first.scene.is_mine))
        table_links = tuple(tuple(sorted(links - {first.hand.root_name})) for links in found.links(is_table))
        return Touched(*found.summed(), other_links, table_links)

    def loads(self) -> Array:
        """What PARTIES put on the objects, (N, 4, 6)."""
        first = self._stages[0]
        readings, centres = (
            np.array([getattr(stage, name) for stage in self._stages]) for name in ("readings", "centres")
        )
        forces, moments, places = np.split(readings[:, :, first.hand.acting], [3, 6], axis=-1)
        about = moments + cross(places - centres[:, :, None], forces)
        acting = np.concatenate([forces, about], axis=-1).mean(axis=1)
        loads = np.zeros((len(self._stages), len(PARTIES), 6))
        table, robot, tips = acting[:, 0], acting[:, 1], acting[:, 2:].sum(axis=1)
        loads[:, 0], loads[:, 1], loads[:, 2] = tips, robot - tips, table
        loads[:, PARTIES.index("gravity"), 2] = -first.scene.mass * first.gravity
        return loads
