"""What a tactile sensor of the fingertips is, and the little that it asks of its world: it knows no engine."""

from __future__ import annotations

import sys
from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, ClassVar, NamedTuple, Protocol, Self

import numpy as np

from graspdsl.arrays import Array, Flags
from graspdsl.hands.fingertips import FingertipShape
from graspdsl.spec.sensing import SampledSensor, TactileSensor
from graspdsl.worlds.touch.signals import Flaws, SensorSignal, Timing
from graspdsl.worlds.touch.surfaces import fingertip_surface

Frames = Sequence[tuple[Array, Array]]  # origin (3,) [m] and rotation (3, 3) of the link of each fingertip


@dataclass(frozen=True, slots=True)
class Fingertip:
    """One fingertip, in the frame of its link: its shape and the centre of that (3,) [m]; its mass [kg], and the centre
    of mass (3,) [m] from the centre of the shape."""

    shape: FingertipShape
    centre: Array
    mass: float
    weight_lever: Array


class FingertipPhysics(Protocol):
    """What a world tells its tactile sensors: of k fingertips, in the order of the robot's contacts, at present."""

    @property
    def tips(self) -> Sequence[Fingertip]:
        """The fingertips."""
        ...

    def frames(self) -> Frames:
        """The frames of the tips' links, in the world."""
        ...

    def wrenches(self) -> Array:
        """The (k, 6) wrenches on the load cells before the tips, force [N] then moment [N·m], in the tips' frames."""
        ...

    def contacts(self) -> tuple[Array, Array, Array]:
        """True contact points [m], normals into the object, forces on it [N], (k, 3) each; NaN where none touches."""
        ...

    def presses(self) -> list[tuple[Array, Array]]:
        """Where the object presses on each fingertip, (c, 3) [m], and the normal forces (c,) [N] there."""
        ...

    def nearest(self, within: float) -> list[tuple[float, Array] | None]:
        """The distance [m] of the object from each fingertip, negative for a dent, and the tip's nearest point (3,);
        None beyond ``within`` [m]."""
        ...


class Clock(NamedTuple):
    """The rates [Hz] of the engine's steps and of the control's ticks."""

    engine: float
    control: float


class TipFrames(NamedTuple):
    """The frames of the links of k fingertips of N hands: origins (N, k, 3) [m], rotations (N, k, 3, 3)."""

    origins: Array
    rotations: Array

    def of(self, row: int) -> Frames:
        """Those of one hand."""
        return list(zip(self.origins[row], self.rotations[row], strict=True))


class TipContact(NamedTuple):
    """A contact as it is felt: its place in the frame of the tip's link; point, normal into the object and force on it
    in the world, (3,) each."""

    place: Array
    point: Array
    normal: Array
    force: Array


class FingertipSensor(ABC):
    """The tactile sensors of all fingertips of a hand. Steps count the engine's steps since the scene was built.

    ``name``: as a spec has it; ``model``: of its settings there; ``called``: what contacts are said to have;
    ``needs_cells``: whether the hand must have a load cell before each tip; ``tares``: whether it has a zero;
    ``sees_ahead``: whether it may know the surface before a tip that does not touch.
    A sensor that takes samples has a ``signal``; one without sees what is there, at once. ``alike`` (k,): of each tip,
    the first one of its shape.
    """

    name: ClassVar[str]
    about: ClassVar[str]
    called: ClassVar[str]
    model: ClassVar[type[TactileSensor]]
    needs_cells: ClassVar[bool] = False
    tares: ClassVar[bool] = False
    sees_ahead: ClassVar[bool] = False

    def __init__(
        self, spec: Any, hand: FingertipPhysics, gravity: float, clock: Clock, seed: np.random.SeedSequence
    ) -> None:
        """spec: the settings, of the ``model``; gravity [m/s²]; seed: of all that is random."""
        self.spec, self.hand, self.gravity, self.clock = spec, hand, gravity, clock
        self.surfaces = [fingertip_surface(tip.shape) for tip in hand.tips]
        shapes = [tip.shape for tip in hand.tips]
        self.alike = np.array([shapes.index(shape) for shape in shapes])
        self.frames: Frames = []
        self.zero = np.zeros(())
        self._at_rest: list[Array] = []
        flaws = self.flaws()
        self.signal = None if flaws is None else _signal(spec, flaws, hand, clock, seed)

    def flaws(self) -> Flaws | None:
        """How its samples differ from what is measured; None for a sensor that takes none."""
        return None

    def due(self, step: int) -> bool:
        """Whether a sample is to be taken now."""
        return self.signal is not None and self.signal.due(step)

    def wait(self, step: int) -> int:
        """In how many steps after this one the next sample falls due."""
        return sys.maxsize if self.signal is None else self.signal.wait(step)

    def sample(self, step: int) -> None:
        """Take the sample that is due."""
        if self.signal is not None:
            self.signal.sample(step, self.measured())

    def measured(self) -> Array:
        """What a sample measures now, (k, d)."""
        return np.zeros((len(self.hand.tips), 0))

    def read(self, step: int) -> Array:
        """The present reading, (k, d), as it is before its zero is taken off."""
        assert self.signal is not None
        return self.signal.read(step)

    def note_rest(self, step: int) -> None:
        """Remember the present reading as one at rest, before any contact."""
        if self.tares:
            self._at_rest.append(self.read(step))

    def tare(self, step: int) -> None:
        """Take the mean of the readings at rest as zero, or the present one if there are none."""
        if self.tares:
            noted, self._at_rest = self._at_rest or [self.read(step)], []
            self.zero = np.asarray(np.mean(noted, axis=0)) if len(noted) > 1 else noted[0]

    @abstractmethod
    def strengths(self, step: int, frames: Frames) -> Array:
        """Take the present reading and give the force (k,) [N] that each tip feels; frames: those of the tips."""

    @abstractmethod
    def contact(self, tip: int) -> TipContact:
        """The contact of a tip that touches, in the present reading."""

    @classmethod
    def strengths_of(cls, sensors: Sequence[Self], steps: Sequence[int], frames: TipFrames) -> Array:
        """The strengths (N, k) of N hands side by side, each at its own step."""
        each = enumerate(zip(sensors, steps, strict=True))
        return np.array([sensor.strengths(step, frames.of(row)) for row, (sensor, step) in each])

    @classmethod
    def contacts_of(cls, sensors: Sequence[Self], touching: Flags, frames: TipFrames) -> Array:
        """The contacts of the tips of N hands that touch, c in all, in order: their places, points, normals and forces,
        (4, c, 3)."""
        del frames  # they were told with the strengths
        found = [sensors[row].contact(tip) for row, tip in np.argwhere(touching).tolist()]
        return np.array(found).swapaxes(0, 1)

    def at(self, tip: int, from_centre: Array) -> tuple[Array, Array]:
        """A point (3,) of a tip's surface, given from the centre of its shape: in the frame of its link, and in the
        world."""
        origin, rotation = self.frames[tip]
        place = self.hand.tips[tip].centre + from_centre
        return place, origin + rotation @ place

    def normal_ahead(self, tip: int) -> Array | None:
        """The normal (3,) into the surface before a tip that does not touch, where the sensor knows it."""
        del tip
        return None


def _signal(
    spec: SampledSensor, flaws: Flaws, hand: FingertipPhysics, clock: Clock, seed: np.random.SeedSequence
) -> SensorSignal:
    period = round(clock.engine / clock.control)
    rate = spec.sampling_rate or clock.control
    timing = Timing(rate, spec.latency, spec.time_constant, 1.0 / clock.engine, period)
    return SensorSignal(flaws, timing, seed.spawn(len(hand.tips)))
