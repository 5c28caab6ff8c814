"""What the engine tells tactile sensors of a hand's fingertips on an object."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from graspdsl.arrays import Array
from graspdsl.worlds.bullet.hand import BulletHand, Tip
from graspdsl.worlds.bullet.scene import Scene, forces_of


@dataclass(frozen=True, slots=True)
class BulletFingertips:
    """The fingertips of a hand before the object of a scene; as tactile sensors and the truth have them."""

    hand: BulletHand
    scene: Scene

    @property
    def tips(self) -> Sequence[Tip]:
        """The fingertips."""
        return self.hand.tips

    def frames(self) -> list[tuple[Array, Array]]:
        """The frames of the tips' links."""
        return self.hand.tip_frames()

    def wrenches(self) -> Array:
        """What the load cells' joints hold up, (k, 6)."""
        return self.hand.cell_readings()

    def contacts(self) -> tuple[Array, Array, Array]:
        """True contact points, normals into the object and forces on it, each (k, 3); NaN rows where none touches."""
        answer = np.full((3, len(self.tips), 3), np.nan)
        touches = [touch for touch in self.scene.touches() if touch.body == self.hand.body and touch.contact[9] > 0.0]
        for row, tip in enumerate(self.tips):
            pressing = [touch for touch in touches if touch.link == tip.link]
            if not pressing:
                continue
            weights = np.array([touch.contact[9] for touch in pressing])
            normal = weights @ np.array([touch.sign * np.array(touch.contact[7]) for touch in pressing])
            answer[0, row] = weights @ np.array([touch.place for touch in pressing]) / weights.sum()
            answer[1, row] = normal / np.linalg.norm(normal)
            answer[2, row] = forces_of(pressing).sum(axis=0)
        return answer[0], answer[1], answer[2]

    def presses(self) -> list[tuple[Array, Array]]:
        """Where the object presses on each fingertip, (c, 3), and the normal forces (c,) [N] there."""
        answer = []
        for tip in self.tips:
            pressing = self.scene.pressing(self.hand, self.scene.object, tip.link)
            points = np.array([c[5] for c in pressing]).reshape(-1, 3)
            answer.append((points, np.array([c[9] for c in pressing])))
        return answer

    def nearest(self, within: float) -> list[tuple[float, Array] | None]:
        """The distance [m] of the object from each fingertip, negative for a dent, and the tip's nearest point (3,)."""
        answer: list[tuple[float, Array] | None] = []
        for tip in self.tips:
            pairs = self.scene.closest(self.hand.body, tip.link, within)
            nearest = min(pairs, key=lambda pair: pair[8], default=None)
            answer.append(None if nearest is None else (nearest[8], np.array(nearest[5])))
        return answer
