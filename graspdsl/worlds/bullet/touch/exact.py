"""The engine's own contacts in place of a sensor."""

from __future__ import annotations

import numpy as np

from graspdsl.arrays import Array
from graspdsl.worlds.bullet.hand import BulletHand
from graspdsl.worlds.bullet.scene import Scene
from graspdsl.worlds.bullet.touch.sensor import Contact, Frames


class ExactContacts:
    """What really touches, without delay."""

    def __init__(self, hand: BulletHand, scene: Scene) -> None:
        self._hand, self._scene = hand, scene
        self._truth: tuple[Array, Array, Array] = (np.zeros(0), np.zeros(0), np.zeros(0))
        self._frames: Frames = []

    def due(self, step: int) -> bool:
        """It takes no samples."""
        del step
        return False

    def sample(self, step: int) -> None:
        """It takes no samples."""

    def note_rest(self, step: int) -> None:
        """It has no zero."""

    def tare(self, step: int) -> None:
        """It has no zero."""

    def strengths(self, step: int, frames: Frames) -> Array:
        """The true forces (k,) [N]."""
        del step
        self._truth, self._frames = self._scene.tip_contacts(self._hand), frames
        return np.asarray(np.nan_to_num(np.linalg.norm(self._truth[2], axis=1)))

    def contact(self, tip: int) -> Contact:
        """The true contact of a tip."""
        point, normal, force = (part[tip] for part in self._truth)
        origin, rotation = self._frames[tip]
        return Contact(rotation.T @ (point - origin), point, normal, force)

    def normal_ahead(self, tip: int) -> Array | None:
        """Nothing is known before a contact."""
        del tip
        return None
