"""Fingertip load cells, read by intrinsic contact sensing."""

from __future__ import annotations

import numpy as np

from graspdsl.arrays import Array
from graspdsl.basis.algebra import cross
from graspdsl.spec.sensing import LoadCell
from graspdsl.worlds.bullet.hand import BulletHand
from graspdsl.worlds.bullet.touch.sensor import Clock, Contact, Frames, RestReadings, signal_of
from graspdsl.worlds.fingertip_surfaces import fingertip_surface
from graspdsl.worlds.sensor_signal import Flaws


class LoadCells:
    """A six-axis cell before each tip, in the frame of the tip's link.

    What it reads late it reads in the frame of the tip, which has moved on meanwhile. The weight of the tip is known in
    every pose and taken off.
    """

    def __init__(
        self,
        spec: LoadCell,
        hand: BulletHand,
        gravity: float,
        clock: Clock,
        seed: np.random.SeedSequence,
    ) -> None:
        self._hand = hand
        self._weight = np.array([0.0, 0.0, -gravity])
        self._surfaces = [fingertip_surface(tip.shape) for tip in hand.tips]
        flaws = Flaws(
            noise=np.repeat([spec.force_noise, spec.moment_noise], 3),
            bias=np.repeat([spec.force_bias, spec.moment_bias], 3),
            drift=np.repeat([spec.force_drift, spec.moment_drift], 3),
            quantum=np.repeat([spec.force_quantum, spec.moment_quantum], 3),
        )
        self._signal = signal_of(spec, flaws, hand, clock, seed)
        self._rest = RestReadings()
        self._zero = np.zeros((len(hand.tips), 6))
        self._loads = self._zero
        self._frames: Frames = []

    def due(self, step: int) -> bool:
        """Whether a sample is to be taken now."""
        return self._signal.due(step)

    def sample(self, step: int) -> None:
        """Take the sample that is due."""
        self._signal.sample(step, self._hand.cell_readings())

    def note_rest(self, step: int) -> None:
        """Remember the present load as one at rest."""
        self._rest.note(self._present_loads(step, self._hand.tip_frames()))

    def tare(self, step: int) -> None:
        """Take the loads at rest, less the tips' own weight, as zero."""
        self._zero = self._rest.zero(self._present_loads(step, self._hand.tip_frames()))

    def _present_loads(self, step: int, frames: Frames) -> Array:
        """The (k, 6) loads that the object puts on the tips, about their shapes' centres, in the tips' frames."""
        loads = []
        for tip, (_, rotation), raw in zip(self._hand.tips, frames, self._signal.read(step), strict=True):
            # The joint answers what it holds up against: minus the object's load and the weight of the tip.
            weight = tip.mass * (rotation.T @ self._weight)
            moment = -raw[3:] + cross(tip.weight_lever, -raw[:3])
            loads.append(np.concatenate([-raw[:3] - weight, moment - cross(tip.weight_lever, weight)]))
        return np.array(loads)

    def strengths(self, step: int, frames: Frames) -> Array:
        """The forces (k,) [N] of the loads, friction and all."""
        self._loads, self._frames = self._present_loads(step, frames) - self._zero, frames
        return np.array([np.linalg.norm(load[:3]) for load in self._loads])

    def contact(self, tip: int) -> Contact:
        """Where the load of a tip acts."""
        load, surface = self._loads[tip], self._surfaces[tip]
        origin, rotation = self._frames[tip]
        from_centre = surface.contact(load[:3], load[3:])
        place = self._hand.tips[tip].centre + from_centre
        normal = rotation @ surface.normal(from_centre)
        return Contact(place, origin + rotation @ place, normal, -rotation @ load[:3])

    def normal_ahead(self, tip: int) -> Array | None:
        """A load cell feels nothing at a distance."""
        del tip
        return None
