"""What a tactile sensor of the fingertips is: it takes samples, and says how strongly and where each tip is touched."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple, Protocol

import numpy as np

from graspdsl.arrays import Array
from graspdsl.spec.sensing import SampledSensor
from graspdsl.worlds.bullet.hand import BulletHand
from graspdsl.worlds.sensor_signal import Flaws, SensorSignal, Timing

Frames = Sequence[tuple[Array, Array]]


class Clock(NamedTuple):
    """The rates [Hz] of the engine's steps and of the control's ticks."""

    engine: float
    control: float


class Contact(NamedTuple):
    """A contact as it is felt: its place in the frame of the tip's link; point, normal into the object and force on it
    in the world, (3,) each."""

    place: Array
    point: Array
    normal: Array
    force: Array


class Sensor(Protocol):
    """The tactile sensors of all fingertips. Steps count the engine's steps since the scene was built."""

    def due(self, step: int) -> bool:
        """Whether a sample is to be taken now."""
        ...

    def sample(self, step: int) -> None:
        """Take the sample that is due."""
        ...

    def note_rest(self, step: int) -> None:
        """Remember the present reading as one at rest, before any contact."""
        ...

    def tare(self, step: int) -> None:
        """Take the mean of the readings at rest as zero, or the present one if there are none."""
        ...

    def strengths(self, step: int, frames: Frames) -> Array:
        """Take the present reading and give the force (k,) [N] that each tip feels; frames: those of the tips."""
        ...

    def contact(self, tip: int) -> Contact:
        """The contact of a tip that touches, in the present reading."""
        ...

    def normal_ahead(self, tip: int) -> Array | None:
        """The normal (3,) into the surface before a tip that does not touch, where the sensor knows it."""
        ...


def signal_of(
    spec: SampledSensor, flaws: Flaws, hand: BulletHand, clock: Clock, seed: np.random.SeedSequence
) -> SensorSignal:
    """The signal of a sensor in every tip."""
    period = round(clock.engine / clock.control)
    rate = spec.sampling_rate or clock.control
    timing = Timing(rate, spec.latency, spec.time_constant, 1.0 / clock.engine, period)
    return SensorSignal(flaws, timing, seed.spawn(len(hand.tips)))


class RestReadings:
    """The zero of a sensor: the mean of what it read at rest."""

    def __init__(self) -> None:
        self._noted: list[Array] = []

    def note(self, reading: Array) -> None:
        """Remember a reading at rest."""
        self._noted.append(reading)

    def zero(self, present: Array) -> Array:
        """The mean of what was noted, or the present reading; what was noted is forgotten."""
        noted, self._noted = self._noted or [present], []
        return np.asarray(np.mean(noted, axis=0)) if len(noted) > 1 else noted[0]
