"""What MuJoCo tells tactile sensors of a hand's fingertips on an object."""

from __future__ import annotations

from collections.abc import Sequence

import mujoco
import numpy as np

from graspdsl.arrays import Array
from graspdsl.worlds.mujoco.hand import MujocoHand
from graspdsl.worlds.mujoco.scene import MujocoScene
from graspdsl.worlds.mujoco.state import State
from graspdsl.worlds.touch.fingertip_sensor import Fingertip

Met = list[tuple[Array, Array, Array]]  # points, normals and forces of the contacts of each tip


class MujocoFingertips:
    """The fingertips of a hand before the object of a scene; as tactile sensors and the truth have them."""

    def __init__(self, state: State, hand: MujocoHand, scene: MujocoScene) -> None:
        self._state, self._hand, self._scene = state, hand, scene
        self._met: tuple[object, Met] = None, []

    @property
    def tips(self) -> Sequence[Fingertip]:
        """The fingertips."""
        return self._hand.tips

    def frames(self) -> list[tuple[Array, Array]]:
        """The frames of the tips' links."""
        return self._hand.tip_frames()

    def wrenches(self) -> Array:
        """What the load cells hold up, (k, 6)."""
        return self._hand.cell_readings()

    def contacts(self) -> tuple[Array, Array, Array]:
        """True contact points, normals into the object and forces on it, each (k, 3); NaN rows where none touches."""
        answer = np.full((3, len(self.tips), 3), np.nan)
        for row, (points, normals, forces) in enumerate(self._touches()):
            weights = np.vecdot(normals, forces)
            if not weights.size:
                continue
            normal = weights @ normals
            answer[0, row] = weights @ points / weights.sum()
            answer[1, row] = normal / np.linalg.norm(normal)
            answer[2, row] = forces.sum(axis=0)
        return answer[0], answer[1], answer[2]

    def presses(self) -> list[tuple[Array, Array]]:
        """Where the object presses on each fingertip, (c, 3), and the normal forces (c,) [N] there."""
        return [(points, np.vecdot(normals, forces)) for points, normals, forces in self._touches()]

    def _touches(self) -> Met:
        """Where each tip presses on the object, looked up once a step."""
        pressing = self._state.pressing
        if self._met[0] is not pressing:
            self._met = pressing, self._scene.touches(self._hand.tip_geoms)
        return self._met[1]

    def nearest(self, within: float) -> list[tuple[float, Array] | None]:
        """The distance [m] of the object from each fingertip, negative for a dent, and the tip's nearest point (3,)."""
        answer: list[tuple[float, Array] | None] = []
        for geom in self._hand.tip_geoms:
            nearest, point = within, np.zeros(3)
            for other in self._scene.geoms:
                ends = np.zeros(6)
                distance = mujoco.mj_geomDistance(self._state.model, self._state.placed, geom, other, within, ends)
                if distance < nearest:
                    nearest, point = distance, ends[:3]
            answer.append(None if nearest >= within else (nearest, point))
        return answer

    def jacobian(self, tip: int, place: Array) -> Array:
        """The linear Jacobian (3, n) of a point of a tip."""
        places = [np.zeros(3)] * len(self.tips)
        places[tip] = place
        return np.asarray(self._hand.tip_jacobians(places)[0][tip])
