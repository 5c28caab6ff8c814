"""The true contacts in place of a sensor."""

from __future__ import annotations

import numpy as np

from graspdsl.arrays import Array
from graspdsl.basis.algebra import length
from graspdsl.spec.sensing import Exact
from graspdsl.worlds.touch.fingertip_sensor import FingertipSensor, Frames, TipContact


class ExactContacts(FingertipSensor):
    """What really touches, without delay."""

    name = "exact"
    about = "the true contacts, without delay"
    called = "true contacts"
    model = Exact

    def strengths(self, step: int, frames: Frames) -> Array:
        """The true forces (k,) [N]."""
        del step
        self.truth, self.frames = self.hand.contacts(), frames
        return np.asarray(np.nan_to_num(length(self.truth[2])))

    def contact(self, tip: int) -> TipContact:
        """The true contact of a tip."""
        point, normal, force = (part[tip] for part in self.truth)
        origin, rotation = self.frames[tip]
        return TipContact(rotation.T @ (point - origin), point, normal, force)
