"""What presses on what on stages of MuJoCo."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from graspdsl.arrays import Array, Flags
from graspdsl.basis.algebra import length
from graspdsl.worlds.mujoco.hand import MujocoHand
from graspdsl.worlds.mujoco.scene import MujocoScene
from graspdsl.worlds.mujoco.state import State
from graspdsl.worlds.protocol import Names


class Touches:
    """The contacts of alike states that carry a force; ``hand`` and ``scene`` are those of any of them.

    Of the fingertips on the objects, c in all: ``state`` and ``tip`` (c,) by number, ``points`` (c, 3) [m], ``normals``
    into the objects, ``forces`` on them [N], and ``presses`` (c,) [N], along the normals.
    """

    def __init__(self, states: Sequence[State], hand: MujocoHand, scene: MujocoScene) -> None:
        self._count, self._hand, self._scene = len(states), hand, scene
        contacts, forces = [state.data.contact for state in states], [state.data.efc_force for state in states]
        places = [contact.efc_address for contact in contacts]
        numbers = np.repeat(np.arange(len(states)), [len(each) for each in places])
        place, force = np.concatenate(places), np.concatenate(forces)
        begins = np.cumsum([0, *(len(each) for each in forces)])[numbers]
        rows = np.flatnonzero(place >= 0)
        rows = rows[force[place[rows] + begins[rows]] > 0.0]
        self._states, self._pairs = numbers[rows], np.concatenate([contact.geom for contact in contacts])[rows]

        mine = scene.is_mine[self._pairs]
        second = mine[:, 1]
        tip = hand.tip_of[np.where(second, self._pairs[:, 0], self._pairs[:, 1])]
        met = mine.any(axis=1) & (tip >= 0)
        rows, sign = rows[met], np.where(second[met], 1.0, -1.0)[:, None]
        self.state, self.tip = self._states[met], tip[met]
        # The engine tells what geom 2 feels, along the axes of the contact, the first its normal from geom 1 to geom 2.
        frames = np.concatenate([contact.frame for contact in contacts])[rows].reshape(-1, 3, 3)
        along = force[(place[rows] + begins[rows])[:, None] + np.arange(3)]
        self.points = np.concatenate([contact.pos for contact in contacts])[rows]
        self.normals, self.forces = sign * frames[:, 0], sign * np.vecmat(along, frames)
        self.presses = np.vecdot(self.normals, self.forces)

    def summed(self) -> tuple[Array, Array, Array, Array]:
        """Of each fingertip (N, k, …) the mean point, by the normal forces, the mean normal, the sum of the forces, all
        NaN where it does not touch, and the sum of the normal forces."""
        tips = len(self._hand.tips)
        at = self.state * tips + self.tip
        sums = np.zeros((self._count * tips, 10))
        weights = self.presses[:, None]
        np.add.at(sums, at, np.hstack([weights, weights * self.points, weights * self.normals, self.forces]))
        each = sums.reshape(self._count, tips, 10)
        presses, points, normals, forces = np.split(each, [1, 4, 7], axis=-1)
        touches = presses > 0.0
        points = points / np.where(touches, presses, np.nan)
        normals = normals / np.where(touches, length(normals)[..., None], np.nan)
        return points, normals, np.where(touches, forces, np.nan), presses[..., 0]

    def links(self, others: Flags) -> Names:
        """What of each robot presses on others than itself, by the names of its links; others: (g,) flags of geoms."""
        mine, other = self._hand.is_mine[self._pairs], others[self._pairs]
        found: list[set[str]] = [set() for _ in range(self._count)]
        for row, side in np.argwhere(mine & other[:, ::-1]).tolist():
            found[self._states[row]].add(self._hand.link_of[self._pairs[row, side]])
        return tuple(found)
