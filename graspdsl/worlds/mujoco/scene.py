"""Table and object inside MuJoCo, and the engine's truth about what touches the object."""

from __future__ import annotations

import numpy as np

from graspdsl.arrays import Array
from graspdsl.basis.algebra import cross
from graspdsl.objects.shapes import Body
from graspdsl.worlds.camera import box_corners
from graspdsl.worlds.mujoco.model import OBJECT
from graspdsl.worlds.mujoco.state import State
from graspdsl.worlds.rigid.engine import EnginePose


class MujocoScene:
    """The object of a model in a state of it. Its frame is that of its shape."""

    def __init__(self, state: State, body: Body) -> None:
        self._state, self._model, self._data, self.mass = state, state.model, state.data, body.mass
        model = state.model
        self.body: int = model.body(OBJECT).id
        self.geoms: list[int] = np.flatnonzero(model.geom_bodyid == self.body).tolist()
        free = model.body_dofnum[self.body] > 0
        joint = model.body_jntadr[self.body]
        self._place: int | None = int(model.jnt_qposadr[joint]) if free else None
        self._motion = int(model.jnt_dofadr[joint])
        self.is_mine = np.isin(np.arange(model.ngeom), self.geoms)

    def pose(self) -> EnginePose:
        """The frame's place [m] and its quaternion, w first."""
        place, turned = self._state.placed.xpos[self.body], self._state.placed.xquat[self.body]
        return tuple(place.tolist()), tuple(turned.tolist())

    def place(self, pose: EnginePose) -> None:
        """Put the object there, at rest."""
        position, quaternion = pose
        if self._place is None:
            self._model.body_pos[self.body], self._model.body_quat[self.body] = position, quaternion
        else:
            self._data.qpos[self._place : self._place + 7] = [*position, *quaternion]
            self._data.qvel[self._motion : self._motion + 6] = 0.0
        self._state.moved()

    def object_pose(self) -> tuple[Array, Array]:
        """The centre of mass (3,) [m] and the rotation (3, 3) of the frame."""
        return self._state.placed.xipos[self.body].copy(), self._state.placed.xmat[self.body].reshape(3, 3).copy()

    def velocity(self) -> tuple[Array, Array]:
        """The velocities (3,) [m/s] of the centre of mass and (3,) [rad/s]."""
        moving, turning = np.split(self._data.qvel[self._motion : self._motion + 6], 2)
        rate = self._state.placed.xmat[self.body].reshape(3, 3) @ turning
        return moving + cross(rate, self._lever()), rate

    def move(self, velocity: Array, rate: Array) -> None:
        """Give the object velocities of its centre of mass (3,) [m/s] and (3,) [rad/s]."""
        turning = self._state.placed.xmat[self.body].reshape(3, 3).T @ rate
        self._data.qvel[self._motion : self._motion + 6] = [*(velocity - cross(rate, self._lever())), *turning]

    def _lever(self) -> Array:
        return np.asarray(self._state.placed.xipos[self.body] - self._state.placed.xpos[self.body])

    def object_corners(self) -> Array:
        """The corners (8, 3) [m] of a box along the axes of the world that the object is in."""
        corners = []
        for geom in self.geoms:
            centre, half = np.split(self._model.geom_aabb[geom], 2)
            local = box_corners(centre - half, centre + half)
            corners.append(
                self._state.placed.geom_xpos[geom] + local @ self._state.placed.geom_xmat[geom].reshape(3, 3).T
            )
        points = np.concatenate(corners)
        return box_corners(points.min(axis=0), points.max(axis=0))
