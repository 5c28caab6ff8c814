"""What MuJoCo tells tactile sensors of a hand's fingertips on an object."""

from __future__ import annotations

from collections.abc import Sequence

import mujoco
import numpy as np

from graspdsl.arrays import Array
from graspdsl.worlds.mujoco.hand import MujocoHand
from graspdsl.worlds.mujoco.scene import MujocoScene
from graspdsl.worlds.mujoco.state import State
from graspdsl.worlds.mujoco.touches import Touches
from graspdsl.worlds.touch.fingertip_sensor import Fingertip


class MujocoFingertips:
    """The fingertips of a hand before the object of a scene; as tactile sensors and the truth have them."""

    def __init__(self, state: State, hand: MujocoHand, scene: MujocoScene) -> None:
        self._state, self._hand, self._scene = state, hand, scene

    @property
    def tips(self) -> Sequence[Fingertip]:
        """The fingertips."""
        return self._hand.tips

    def frames(self) -> list[tuple[Array, Array]]:
        """The frames of the tips' links."""
        return list(zip(*self._hand.tip_frames(), strict=True))

    def wrenches(self) -> Array:
        """What the load cells hold up, (k, 6)."""
        return self._hand.cell_readings()

    def contacts(self) -> tuple[Array, Array, Array]:
        """True contact points, normals into the object and forces on it, each (k, 3); NaN rows where none touches."""
        points, normals, forces, _ = self._touches().summed()
        return points[0], normals[0], forces[0]

    def presses(self) -> list[tuple[Array, Array]]:
        """Where the object presses on each fingertip, (c, 3), and the normal forces (c,) [N] there."""
        found = self._touches()
        return [(found.points[found.tip == tip], found.presses[found.tip == tip]) for tip in range(len(self.tips))]

    def _touches(self) -> Touches:
        return Touches([self._state], self._hand, self._scene)

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
