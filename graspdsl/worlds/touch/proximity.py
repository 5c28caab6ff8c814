"""Proximity sensors in the fingertips: the distance of the nearest surface, and where on the tip it is nearest."""

from __future__ import annotations

from functools import cached_property

import numpy as np

from graspdsl.arrays import Array
from graspdsl.spec.sensing import Proximity
from graspdsl.worlds.touch.compliance import force_of_dent
from graspdsl.worlds.touch.fingertip_sensor import FingertipSensor, Frames, TipContact
from graspdsl.worlds.touch.signals import Flaws

FAINT = 0.3  # of the tip's size: a shorter mean of directions tells nothing


class ProximitySensors(FingertipSensor):
    """A ring of infrared sensors under each tip's soft, clear cover.

    A sample is the distance [m] between tip and object and the place on the tip that is nearest to it. The normal is
    that of the tip's surface there. Once the distance is negative, the cover is dented, and its stiffness makes a force
    of the dent: a stand-in for a force sensor, which feels no friction.
    """

    name = "proximity"
    about = "infrared sensors in each fingertip: the surface ahead, and a force from how deep the tip is dented"
    called = "proximity sensors"
    model = Proximity
    sees_ahead = True

    def flaws(self) -> Flaws:
        """Of distances, then of directions."""
        spec: Proximity = self.spec
        return Flaws(
            noise=np.array([spec.distance_noise, *[spec.direction_noise] * 3]),
            bias=np.array([spec.distance_bias, *[spec.direction_bias] * 3]),
            drift=np.array([spec.distance_drift, *[spec.direction_drift] * 3]),
            quantum=np.array([spec.distance_quantum, 0.0, 0.0, 0.0]),
        )

    @cached_property
    def _sizes(self) -> Array:
        """Places on a tip are measured in sizes of the tip, so that an error of direction is one of place."""
        return np.array([np.linalg.norm(surface.nearest(np.zeros(3))) for surface in self.surfaces])

    def measured(self) -> Array:
        """Distances and directions (k, 4); out of range, the distance is the range and there is no direction."""
        values = np.zeros((len(self.hand.tips), 4))
        values[:, 0] = self.spec.range
        frames = self.hand.frames()
        for row, nearest in enumerate(self.hand.nearest(self.spec.range)):
            if nearest is not None:
                distance, point = nearest
                origin, rotation = frames[row]
                local = rotation.T @ (point - origin) - self.hand.tips[row].centre
                values[row] = [distance, *(local / self._sizes[row])]
        return values

    def strengths(self, step: int, frames: Frames) -> Array:
        """The forces (k,) [N] that the dents take."""
        self.readings, self.frames = self.read(step), frames
        return force_of_dent(-self.readings[:, 0], self.spec.stiffness)

    def _place(self, tip: int) -> Array:
        """The place on the surface that is nearest to the object, from the centre, in the tip's frame."""
        return self.surfaces[tip].nearest(self.readings[tip, 1:] * self._sizes[tip])

    def contact(self, tip: int) -> TipContact:
        """The contact of a dented tip."""
        from_centre = self._place(tip)
        normal = self.frames[tip][1] @ self.surfaces[tip].normal(from_centre)
        force = force_of_dent(-self.readings[tip, 0], self.spec.stiffness)
        return TipContact(*self.at(tip, from_centre), normal, force * normal)

    def normal_ahead(self, tip: int) -> Array | None:
        """The normal into the surface that is nearest, within range."""
        distance, *direction = self.readings[tip].tolist()
        if distance >= self.spec.range or np.linalg.norm(direction) < FAINT:
            return None
        return np.asarray(self.frames[tip][1] @ self.surfaces[tip].normal(self._place(tip)))
