"""A state of a model of MuJoCo, whose geometry is worked out where it is asked for."""

from __future__ import annotations

import math

import mujoco

from graspdsl.worlds.protocol import WorldCrashError

# It would write a file of its warnings into the folder one is in; what leaves the realm of numbers is told
# by ``must_be_finite``.
mujoco.set_mju_user_warning(lambda _: None)


class State:
    """A model and its data. ``model`` is the state's own and may be changed."""

    def __init__(self, model: mujoco.MjModel) -> None:
        self.model, self.data = model, mujoco.MjData(model)
        self._moved = True

    def step(self) -> None:
        """Simulate one time step. Contacts, forces and readings are then those at its beginning."""
        mujoco.mj_step(self.model, self.data)
        self._moved = True

    def must_be_finite(self) -> None:
        """Raises WorldCrashError where accelerations are not numbers; once they are none, they stay so."""
        if not math.isfinite(self.data.qacc.sum()):
            raise WorldCrashError("the accelerations are not numbers")

    def moved(self) -> None:
        """Something is elsewhere."""
        self._moved = True

    @property
    def placed(self) -> mujoco.MjData:
        """The data with every body where it is now."""
        if self._moved:
            mujoco.mj_kinematics(self.model, self.data)
            mujoco.mj_comPos(self.model, self.data)
            self._moved = False
        return self.data
