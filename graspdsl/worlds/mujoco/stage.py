"""MuJoCo as an engine of rigid bodies: hand, object and table in one model."""

from __future__ import annotations

import copy
import math
from collections.abc import Iterable

import mujoco
import numpy as np

from graspdsl.arrays import Array
from graspdsl.basis.algebra import cross
from graspdsl.objects.shapes import Body
from graspdsl.worlds.kind import Anchor, Effort, WorldSettings
from graspdsl.worlds.mujoco.fingertips import MujocoFingertips
from graspdsl.worlds.mujoco.hand import MujocoHand
from graspdsl.worlds.mujoco.model import ACTING, HELD, TABLE, TipBody, part_overlapping, robot_spec, scene_spec
from graspdsl.worlds.mujoco.scene import MujocoScene
from graspdsl.worlds.mujoco.state import State
from graspdsl.worlds.protocol import PARTIES


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

    def table(self, body: Body, table_friction: float, gravity: float) -> MujocoStage:
        """An object on the table."""
        return MujocoStage(self._compiled(scene_spec(body, table_friction, gravity, Anchor.NONE)), body, gravity)

    def _compiled(self, spec: mujoco.MjSpec) -> mujoco.MjModel:
        spec.option.timestep, spec.option.iterations = self._effort.time_step, self._effort.solver_iterations
        return spec.compile()

    def close(self) -> None:
        """Forget the model."""
        self._built = None


class MujocoStage:
    """A state of a model of the engine; without a hand until one is put there."""

    hand: MujocoHand
    fingertips: MujocoFingertips

    def __init__(self, model: mujoco.MjModel, body: Body, gravity: float) -> None:
        self.state, self._gravity = State(model), gravity
        self.scene = MujocoScene(self.state, body)
        self._table = model.geom(TABLE).id
        names = [model.sensor(number).name for number in range(model.nsensor)]
        acting = [name for name in names if name.startswith(ACTING)]
        self._acting = np.array([model.sensor(name).adr + np.arange(9) for name in acting], dtype=int).reshape(-1, 9)
        self.forget()

    def put_hand(self, settings: WorldSettings, tips: list[TipBody], position: Array, quaternion: Array) -> None:
        """The robot's root at a position (3,) [m] and quaternion (4,)."""
        self.hand = MujocoHand(self.state, settings.robot, tips)
        self.hand.move_root(position, quaternion)
        self.fingertips = MujocoFingertips(self.state, self.hand, self.scene)

    def step(self) -> None:
        """Simulate one time step, and note what acted on the object at its beginning."""
        self.state.step()
        data = self.state.data
        self._acted.append((data.sensordata[self._acting], data.xipos[self.scene.body].copy()))

    def soften(self) -> None:
        """Give the fingertips the stiffness that belongs to how they press now."""
        self.hand.press([float(forces.sum()) for _, forces in self.fingertips.presses()])

    def attach(self) -> None:
        """Fix the object to the palm where it is."""
        model, data = self.state.model, self.state.placed
        weld = model.eq(HELD).id
        palm, held = model.eq_obj1id[weld], self.scene.body
        turned = data.xmat[palm].reshape(3, 3).T
        relative = np.zeros(4)
        mujoco.mju_mat2Quat(relative, (turned @ data.xmat[held].reshape(3, 3)).ravel())
        place = turned @ (data.xpos[held] - data.xpos[palm])
        model.eq_data[weld, :11] = [0.0, 0.0, 0.0, *place, *relative, 1.0]
        data.eq_active[weld] = 1

    def clearance(self, links: set[int] | None, within: float) -> float:
        """The least distance [m] of links from table and object."""
        geoms = self.hand.geoms if links is None else [geom for link in links for geom in self.hand.geoms_of(link)]
        return self._least(geoms, [self._table, *self.scene.geoms], within)

    def distance(self, link: int, within: float) -> float:
        """The distance [m] of a link from the object."""
        return self._least(self.hand.geoms_of(link), self.scene.geoms, within)

    def _least(self, geoms: Iterable[int], others: Iterable[int], within: float) -> float:
        model, data = self.state.model, self.state.placed
        distances = (
            mujoco.mj_geomDistance(model, data, geom, other, within, None) for geom in geoms for other in others
        )
        least = min(distances, default=within)
        return least if least < within else math.inf

    def other_links(self) -> tuple[str, ...]:
        """Links that press on the object."""
        links = self._pressing(self.scene.geoms)
        return tuple(sorted({self.hand.link_of[geom] for geom in links if geom not in self.hand.tip_geoms}))

    def table_links(self) -> tuple[str, ...]:
        """Links that press on the table."""
        names = {self.hand.link_of[geom] for geom in self._pressing([self._table])}
        return tuple(sorted(names - {self.hand.root_name}))

    def _pressing(self, others: list[int]) -> set[int]:
        """The robot's geoms that press on one of some geoms."""
        pairs = self.state.pressing[1].reshape(-1, 2).tolist()
        met = {mine for one, two in pairs for mine, other in ((one, two), (two, one)) if other in others}
        return met & self.hand.link_of.keys()

    def forget(self) -> None:
        """Forget what has acted on the object."""
        self._acted: list[tuple[Array, Array]] = []

    def loads(self) -> Array:
        """What PARTIES put on the object."""
        loads = np.zeros((len(PARTIES), 6))
        if self._acted:
            acted, centres = (np.array(each) for each in zip(*self._acted, strict=True))
            forces, moments, places = (acted[..., part : part + 3] for part in (0, 3, 6))
            about = moments + cross(places - centres[:, None], forces)
            table, robot, *tips = np.concatenate([forces, about], axis=-1).mean(axis=0)
            loads[:3] = np.sum(tips, axis=0), robot - np.sum(tips, axis=0), table
        loads[PARTIES.index("gravity"), 2] = -self.scene.mass * self._gravity
        return loads

    def close(self) -> None:
        """Nothing is held."""
