"""Fingertip skins, read by extrinsic contact sensing: taxels that feel normal pressure."""

from __future__ import annotations

import numpy as np

from graspdsl.arrays import Array
from graspdsl.spec.sensing import Skin
from graspdsl.worlds.bullet.hand import BulletHand
from graspdsl.worlds.bullet.scene import Scene
from graspdsl.worlds.bullet.touch.sensor import Clock, Contact, Frames, RestReadings, signal_of
from graspdsl.worlds.fingertip_surfaces import fingertip_surface
from graspdsl.worlds.sensor_signal import Flaws

TAXEL_DEVIATIONS = 5.0  # of noise that a taxel must exceed; there are hundreds of them


class Skins:
    """A grid of taxels all over each tip.

    The normal force of each of the engine's contacts is spread over the taxels around it with a Gaussian footprint, as
    a soft cover does; friction is not felt. The contact is where the pressure around the strongest taxel has its
    centroid, put on the tip's surface, its force the sum of that pressure along the surface's normal.
    """

    def __init__(self, spec: Skin, hand: BulletHand, scene: Scene, clock: Clock, seed: np.random.SeedSequence) -> None:
        self._hand, self._scene, self._spec = hand, scene, spec
        self._surfaces = [fingertip_surface(tip.shape) for tip in hand.tips]
        self._taxels = [surface.taxels(spec.pitch) for surface in self._surfaces]
        self._count = max(len(taxels.points) for taxels in self._taxels)
        flaws = Flaws(
            noise=np.full(self._count, spec.taxel_noise),
            bias=np.full(self._count, spec.taxel_bias),
            drift=np.full(self._count, spec.taxel_drift),
            quantum=np.full(self._count, spec.taxel_quantum),
        )
        self._signal = signal_of(spec, flaws, hand, clock, seed)
        noise = TAXEL_DEVIATIONS * spec.taxel_noise_at(clock.control)
        self._threshold = noise if spec.threshold is None else spec.threshold
        self._rest = RestReadings()
        self._zero = np.zeros((len(hand.tips), self._count))
        self._pressed: list[tuple[Array, Array]] = []
        self._frames: Frames = []

    def due(self, step: int) -> bool:
        """Whether a sample is to be taken now."""
        return self._signal.due(step)

    def sample(self, step: int) -> None:
        """Take the sample that is due."""
        frames = self._hand.tip_frames()
        forces = np.zeros((len(frames), self._count))
        for row, (points, presses) in enumerate(self._scene.tip_presses(self._hand)):
            if len(presses):
                origin, rotation = frames[row]
                forces[row] = self._spread(row, (points - origin) @ rotation - self._hand.tips[row].centre, presses)
        self._signal.sample(step, forces)

    def _spread(self, tip: int, points: Array, presses: Array) -> Array:
        """The force (t,) [N] on each taxel under normal forces (c,) [N] at points (c, 3), from the centre."""
        taxels, surface = self._taxels[tip], self._surfaces[tip]
        feet = np.array([surface.nearest(point) for point in points])
        squares = np.sum((taxels.points - feet[:, None]) ** 2, axis=2)
        nearest = squares.min(axis=1, keepdims=True)  # so that a footprint smaller than the pitch still presses
        footprints = np.exp((nearest - squares) / (2.0 * self._spec.patch**2)) * taxels.areas
        forces = np.zeros(self._count)
        forces[: len(taxels.areas)] = presses @ (footprints / footprints.sum(axis=1, keepdims=True))
        return forces

    def note_rest(self, step: int) -> None:
        """Remember what the taxels read at rest."""
        self._rest.note(self._signal.read(step))

    def tare(self, step: int) -> None:
        """Take what the taxels read at rest as zero."""
        self._zero = self._rest.zero(self._signal.read(step))

    def strengths(self, step: int, frames: Frames) -> Array:
        """The sums (k,) [N] of the pressure around the strongest taxels; zero where none stands out of the noise."""
        self._frames = frames
        self._pressed = [self._around_strongest(row, forces) for row, forces in enumerate(self._readings(step))]
        return np.array([max(0.0, float(forces.sum())) for _, forces in self._pressed])

    def _readings(self, step: int) -> Array:
        return np.asarray(self._signal.read(step) - self._zero)

    def _around_strongest(self, tip: int, forces: Array) -> tuple[Array, Array]:
        """The points and forces of the taxels within the window about the strongest one."""
        points = self._taxels[tip].points
        forces = forces[: len(points)]
        strongest = int(forces.argmax())
        if forces[strongest] <= self._threshold:
            return points[:0], forces[:0]
        inside = np.sum((points - points[strongest]) ** 2, axis=1) <= self._spec.window**2
        return points[inside], forces[inside]

    def contact(self, tip: int) -> Contact:
        """The centroid of the pressure on a tip."""
        points, forces = self._pressed[tip]
        surface = self._surfaces[tip]
        origin, rotation = self._frames[tip]
        total = float(forces.sum())
        from_centre = surface.nearest(forces @ points / total)
        place = self._hand.tips[tip].centre + from_centre
        normal = rotation @ surface.normal(from_centre)
        return Contact(place, origin + rotation @ place, normal, total * normal)

    def normal_ahead(self, tip: int) -> Array | None:
        """A skin feels nothing at a distance."""
        del tip
        return None
