"""The mujoco world holds an object at the palm where it is when a trial starts."""

from __future__ import annotations

import numpy as np

from graspdsl.arrays import Array
from graspdsl.worlds.kind import Anchor
from graspdsl.worlds.mujoco.kind import Mujoco
from graspdsl.worlds.mujoco.stages import MujocoEngine
from graspdsl.worlds.rigid.world import RigidWorld

from .scenes import moved, opened, settings, side_start


def test_a_held_object_moves_with_the_palm() -> None:
    with opened(RigidWorld(MujocoEngine(Mujoco.effort), settings(anchor=Anchor.HAND))) as world:
        world.reset(side_start(), 0)

        def poses() -> tuple[Array, Array, Array]:
            data = world.stage.state.placed
            palm, held = data.body("palm"), data.body("object")
            turn = palm.xmat.reshape(3, 3).T
            own: Array = held.xmat.reshape(3, 3).copy()
            return turn @ (held.xpos - palm.xpos), turn @ own, own

        place, turn, before = poses()
        for _ in range(100):
            world.step(moved(wrist_roll_x=0.005, wrist_roll_y=-0.004, wrist_roll_z=0.006))
            now, turned, own = poses()
            assert np.linalg.norm(now - place) < 1e-3
            assert np.linalg.norm(turned - turn) < 0.014  # √2 · 0.01 rad
        assert np.linalg.norm(own - before) > 0.7
