"""A stage of MuJoCo: hand, object and table in a state of one model."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable

import mujoco
import numpy as np

from graspdsl.arrays import Array
from graspdsl.objects.shapes import Body
from graspdsl.worlds.kind import WorldSettings
from graspdsl.worlds.mujoco.fingertips import MujocoFingertips
from graspdsl.worlds.mujoco.hand import MujocoHand
from graspdsl.worlds.mujoco.model import HELD, TABLE, TipBody
from graspdsl.worlds.mujoco.scene import MujocoScene
from graspdsl.worlds.mujoco.state import State
from graspdsl.worlds.rigid.engine import stretches


class MujocoStage:
    """A state of a model of the engine; without a hand until one is put there.

    ``readings`` (s, r) of all sensors of the model in the steps of the last tick, and ``centres`` (s, 3), where the
    object's centre of mass was.
    """

    hand: MujocoHand
    fingertips: MujocoFingertips
    readings: Array
    centres: Array

    def __init__(self, model: mujoco.MjModel, body: Body, gravity: float) -> None:
        self.state, self.gravity = State(model), gravity
        self.scene = MujocoScene(self.state, body)
        self.table = model.geom(TABLE).id

    def put_hand(self, settings: WorldSettings, tips: list[TipBody], position: Array, quaternion: Array) -> None:
        """The robot's root at a position (3,) [m] and quaternion (4,)."""
        self.hand = MujocoHand(self.state, settings.robot, tips)
        self.hand.move_root(position, quaternion)
        self.fingertips = MujocoFingertips(self.state, self.hand, self.scene)

    def step(self) -> None:
        """Simulate one time step."""
        self.state.step()
        self.state.must_be_finite()

    def simulate(self, targets: Array, sense: Callable[[int], int]) -> None:
        """Simulate a tick, and note what acted on the object at the beginning of each of its steps."""
        model, data, centre = self.state.model, self.state.data, self.state.data.xipos[self.scene.body]
        self.readings, self.centres = np.empty((len(targets), len(data.sensordata))), np.empty((len(targets), 3))
        control, reading = data.ctrl, data.sensordata
        each = list(zip(self.hand.controls(targets), self.readings, self.centres, strict=True))
        for ahead in stretches(len(targets), sense):
            for told, readings, centres in each[ahead]:
                control[:] = told
                mujoco.mj_step(model, data)
                readings[:], centres[:] = reading, centre
            self.state.moved()
        self.state.must_be_finite()

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
        return self._least(geoms, [self.table, *self.scene.geoms], within)

    def distance(self, link: int, within: float) -> float:
        """The distance [m] of a link from the object."""
        return self._least(self.hand.geoms_of(link), self.scene.geoms, within)

    def _least(self, geoms: Iterable[int], others: Iterable[int], within: float) -> float:
        model, data = self.state.model, self.state.placed
        least = within
        for geom in geoms:
            for other in others:
                distance = mujoco.mj_geomDistance(model, data, geom, other, least if least > 0.0 else 0.0, None)
                if distance < least:
                    least = distance
        return least if least < within else math.inf

    def close(self) -> None:
        """Nothing is held."""
