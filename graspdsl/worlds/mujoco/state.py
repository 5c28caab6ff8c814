"""A state of a model of MuJoCo, whose geometry is worked out where it is asked for."""

from __future__ import annotations

import math

import mujoco
import numpy as np

from graspdsl.arrays import Rows
from graspdsl.worlds.protocol import WorldCrashError

# It would write a file of its warnings into the folder one is in; what leaves the realm of numbers is told by ``step``.
mujoco.set_mju_user_warning(lambda _: None)


class State:
    """A model and its data. ``model`` is the state's own and may be changed."""

    def __init__(self, model: mujoco.MjModel) -> None:
        self.model, self.data = model, mujoco.MjData(model)
        self._moved = True
        self._pressing: tuple[Rows, Rows] | None = None

    def step(self) -> None:
        """Simulate one time step. Contacts, forces and readings are then those at its beginning."""
        mujoco.mj_step(self.model, self.data)
        if not math.isfinite(self.data.qacc.sum()):
            raise WorldCrashError("the accelerations are not numbers")
        self._moved, self._pressing = True, None

    def moved(self) -> None:
        """Something has been put elsewhere."""
        self._moved = True

    @property
    def pressing(self) -> tuple[Rows, Rows]:
        """The contacts that carry a force, (c,), and their pairs of geoms (c, 2)."""
        if self._pressing is None:
            contact = self.data.contact
            able = np.flatnonzero(contact.efc_address >= 0)
            rows = able[self.data.efc_force[contact.efc_address[able]] > 0.0]
            self._pressing = rows, contact.geom[rows]
        return self._pressing

    @property
    def placed(self) -> mujoco.MjData:
        """The data with every body where it is now."""
        if self._moved:
            mujoco.mj_kinematics(self.model, self.data)
            mujoco.mj_comPos(self.model, self.data)
            self._moved = False
        return self.data
