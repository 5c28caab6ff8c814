"""Proximity sensors in the fingertips: the distance of the nearest surface, and where on the tip it is nearest."""

from __future__ import annotations

import numpy as np

from graspdsl.arrays import Array
from graspdsl.spec.sensing import Proximity
from graspdsl.worlds.bullet.hand import BulletHand
from graspdsl.worlds.bullet.scene import Scene
from graspdsl.worlds.bullet.touch.sensor import Clock, Contact, Frames, signal_of
from graspdsl.worlds.fingertip_compliance import force_of_dent
from graspdsl.worlds.fingertip_surfaces import fingertip_surface
from graspdsl.worlds.sensor_signal import Flaws

FAINT = 0.3  # of the tip's size: a shorter mean of directions tells nothing


class ProximitySensors:
    """A ring of infrared sensors under each tip's soft, clear cover.

    A sample is the distance [m] between tip and object and the place on the tip that is nearest to it. The normal is
    that of the tip's surface there. Once the distance is negative, the cover is dented, and its stiffness makes a force
    of the dent: a stand-in for a force sensor, which feels no friction.
    """

    def __init__(
        self,
        spec: Proximity,
        hand: BulletHand,
        scene: Scene,
        clock: Clock,
        seed: np.random.SeedSequence,
    ) -> None:
        self._hand, self._scene, self._spec = hand, scene, spec
        self._surfaces = [fingertip_surface(tip.shape) for tip in hand.tips]
        # Places on a tip are measured in sizes of the tip, so that an error of direction is one of place.
        self._sizes = np.array([np.linalg.norm(surface.nearest(np.zeros(3))) for surface in self._surfaces])
        flaws = Flaws(
            noise=np.array([spec.distance_noise, *[spec.direction_noise] * 3]),
            bias=np.array([spec.distance_bias, *[spec.direction_bias] * 3]),
            drift=np.array([spec.distance_drift, *[spec.direction_drift] * 3]),
            quantum=np.array([spec.distance_quantum, 0.0, 0.0, 0.0]),
        )
        self._signal = signal_of(spec, flaws, hand, clock, seed)
        self._readings = np.zeros((len(hand.tips), 4))
        self._frames: Frames = []

    def due(self, step: int) -> bool:
        """Whether a sample is to be taken now."""
        return self._signal.due(step)

    def sample(self, step: int) -> None:
        """Take the sample that is due; out of range, the distance is the range and there is no direction."""
        values = np.zeros((len(self._hand.tips), 4))
        values[:, 0] = self._spec.range
        frames = self._hand.tip_frames()
        for row, nearest in enumerate(self._scene.nearest_to_tips(self._hand, self._spec.range)):
            if nearest is not None:
                distance, point = nearest
                origin, rotation = frames[row]
                local = rotation.T @ (point - origin) - self._hand.tips[row].centre
                values[row] = [distance, *(local / self._sizes[row])]
        self._signal.sample(step, values)

    def note_rest(self, step: int) -> None:
        """There is nothing at rest to take as zero."""

    def tare(self, step: int) -> None:
        """There is nothing at rest to take as zero."""

    def strengths(self, step: int, frames: Frames) -> Array:
        """The forces (k,) [N] that the dents take."""
        self._readings, self._frames = self._signal.read(step), frames
        return force_of_dent(-self._readings[:, 0], self._spec.stiffness)

    def _place(self, tip: int) -> Array:
        """The place on the surface that is nearest to the object, from the centre, in the tip's frame."""
        return self._surfaces[tip].nearest(self._readings[tip, 1:] * self._sizes[tip])

    def contact(self, tip: int) -> Contact:
        """The contact of a dented tip."""
        origin, rotation = self._frames[tip]
        from_centre = self._place(tip)
        place = self._hand.tips[tip].centre + from_centre
        normal = rotation @ self._surfaces[tip].normal(from_centre)
        force = force_of_dent(-self._readings[tip, 0], self._spec.stiffness)
        return Contact(place, origin + rotation @ place, normal, force * normal)

    def normal_ahead(self, tip: int) -> Array | None:
        """The normal into the surface that is nearest, within range."""
        distance, *direction = self._readings[tip].tolist()
        if distance >= self._spec.range or np.linalg.norm(direction) < FAINT:
            return None
        return np.asarray(self._frames[tip][1] @ self._surfaces[tip].normal(self._place(tip)))
