"""The simulator's own verdict on a grasp: squeeze, lift, hold and shake, and see whether the object stays."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from graspdsl.arrays import Array
from graspdsl.quality.carrying import Carrier
from graspdsl.quality.grade import Found, Grade, Grasp, Metric, Quantity
from graspdsl.worlds.protocol import PARTIES, Command, Test, Truth, WorldCrashError

AXES = np.eye(3)
UP = AXES[2]


def rise(share: float) -> float:
    """From 0 to 1 as ``share`` of the time goes from 0 to 1, with the least jerk: 10 s³ − 15 s⁴ + 6 s⁵.

    Over a height h in a time T the acceleration is at most 5.774 h / T².
    """
    s = min(1.0, max(0.0, share))
    return s**3 * (10.0 + s * (6.0 * s - 15.0))


def sway(cycles: float, count: int) -> float:
    """sin(2π c) after c of a whole number of cycles, its first and last half cycle swelling from rest and back.

    At amplitude A and angular frequency ω the acceleration is about A ω² in whole cycles.
    """
    if not 0.0 < cycles < count:
        return 0.0
    return math.sin(2.0 * math.pi * cycles) * rise(2.0 * cycles) * rise(2.0 * (count - cycles))


@dataclass(frozen=True, slots=True)
class Handling:
    """How a grasp is tested. Forces in N, lengths in m, times in s, frequency in Hz.

    squeeze: the largest normal force of a fingertip, reached in ``ramp``, by default what a Barrett finger can press
    for long; height, in ``rise``, then ``hold``. The shake goes along the world's x, y and z in turn, ``cycles`` each.
    slip: how far the part of the object between the contacts may move in the palm's frame; an object that only swings
    about its contacts has not slipped.
    """

    squeeze: float = 15.0
    ramp: float = 2.0
    height: float = 0.10
    rise: float = 1.0
    hold: float = 1.0
    amplitude: float = 0.02
    frequency: float = 2.0
    cycles: int = 2
    slip: float = 0.03

    @property
    def acceleration(self) -> float:
        """The largest acceleration of the shake [m/s²], by differences of its path."""
        cycles = np.linspace(0.0, self.cycles, 1000 * self.cycles + 1)
        path = np.array([sway(cycle, self.cycles) for cycle in cycles])
        second = np.diff(path, 2) / (cycles[1] - cycles[0]) ** 2
        return float(self.amplitude * self.frequency**2 * np.abs(second).max())


TEST = Handling()
OF_THE_LIFT = Metric(None, "of the lift alone")


@dataclass(frozen=True, slots=True)
class Held:
    """Whether a grasp kept its object through a part of the test, and if not why.

    displacement [m]: the largest, in the palm's frame, of the object's part between the contacts, None without a test;
    contacts: fingertips that touch at the end; lost_at [s]: when it had moved too far, from the beginning of the part,
    None if it never had; squeeze [N]: at the end of the ramp. borne: what the fingertips bear while the lifted object
    is held, over its weight.
    """

    kept: bool
    reason: str
    displacement: float | None = None
    contacts: int = 0
    lost_at: float | None = None
    squeeze: float | None = None
    borne: Metric = OF_THE_LIFT


class Handled:
    """The test of a grasp: its object is squeezed and lifted, and then, if it is asked, shaken.

    The world goes on from where it is and is not put back. ``lift``, ``shake``: whether the object was kept; None
    before that was tried.
    """

    def __init__(self, grasp: Grasp, handling: Handling = TEST) -> None:
        self._grasp, self._handling = grasp, handling
        self._test: _Test | None = None
        self.lift: Held | None = None
        self.shake: Held | None = None

    def lifted(self) -> Test[Held]:
        """Whether the object is kept when lifted and held."""
        if self.lift is None:
            try:
                self._test = yield from _squeezed(self._grasp, self._handling)
                self.lift = yield from self._test.lift()
            except WorldCrashError as error:
                self.lift = _crashed(error)
        return self.lift

    def shaken(self) -> Test[Held]:
        """Whether it is kept when shaken after that."""
        lift = yield from self.lifted()
        if self.shake is None and lift.kept and self._test is not None:
            try:
                self.shake = yield from self._test.shake()
            except WorldCrashError as error:
                self.shake = _crashed(error)
        self.shake = self.shake or Held(False, "dropped before the shake")
        return self.shake


def _crashed(error: WorldCrashError) -> Held:
    return Held(False, str(error), borne=Metric(None, str(error)))


def _squeezed(grasp: Grasp, handling: Handling) -> Test[_Test]:
    """The test of a grasp whose hand has taken hold."""
    assert grasp.world is not None
    seen, truth = yield Command("q", np.zeros(len(grasp.world.info.joints)))
    test = _Test(grasp, handling, Carrier(grasp.world, grasp.robot, list(grasp.contacts), seen), truth)
    yield from test.squeeze()
    return test


class _Test:
    def __init__(self, grasp: Grasp, handling: Handling, carrier: Carrier, truth: Truth) -> None:
        """truth: that of the present tick."""
        assert grasp.world is not None
        self._world, self._contacts, self._handling = grasp.world, list(grasp.contacts), handling
        self._carrier, self._truth = carrier, truth
        self._raised, self._loads = np.zeros(3), list[Array]()
        between = truth.points[self._contacts].mean(axis=0) - truth.object_position
        self._between = truth.object_rotation.T @ between
        self._squeeze = carrier.squeeze

    def squeeze(self) -> Test[None]:
        """Raise the squeeze to that of the test."""
        handling, begun, ticks = self._handling, self._squeeze, self._ticks(self._handling.ramp)
        for tick in range(1, ticks + 1):
            yield from self._carried(np.zeros(3), begun + tick / ticks * (handling.squeeze - begun))
        self._squeeze = self._carrier.squeeze

    def lift(self) -> Test[Held]:
        """Lift and hold."""
        handling = self._handling
        rest = self._held_part()[2]

        def path(time: float) -> Array:
            return np.asarray(handling.height * rise(time / handling.rise) * UP)

        held = yield from self._kept_along(path, handling.rise + handling.hold)
        self._raised = path(math.inf)
        risen = self._held_part()[2] - rest
        if held.kept and risen < handling.height - handling.slip:
            held = dataclasses.replace(held, kept=False, reason="the object did not rise with the hand")
        borne = self._borne(self._ticks(handling.hold)) if held.kept else Metric(None, held.reason)
        return dataclasses.replace(held, borne=borne)

    def shake(self) -> Test[Held]:
        """Shake along three axes in turn."""
        handling = self._handling
        each = handling.cycles / handling.frequency

        def path(time: float) -> Array:
            axis = min(2, int(time / each))
            cycles = handling.frequency * (time - axis * each)
            return np.asarray(self._raised + handling.amplitude * sway(cycles, handling.cycles) * AXES[axis])

        return (yield from self._kept_along(path, 3.0 * each))

    def _carried(self, offset: Array, squeeze: float) -> Test[None]:
        """One tick with the palm led to an offset (3,) [m]."""
        self._carrier.observation, self._truth = yield self._carrier.command(offset, squeeze)

    def _kept_along(self, path: Callable[[float], Array], duration: float) -> Test[Held]:
        """Follow a path; stop when the object has moved too far in the hand."""
        before, largest, lost_at = self._in_palm(), 0.0, None
        for tick in range(1, self._ticks(duration) + 1):
            time = tick / self._world.info.rate
            yield from self._carried(path(time), self._handling.squeeze)
            self._loads.append(self._truth.loads)
            largest = max(largest, float(np.linalg.norm(self._in_palm() - before)))
            if not largest <= self._handling.slip:
                lost_at = time
                break
        touching = int(np.isfinite(self._truth.points[self._contacts]).all(axis=1).sum())
        slip = f"{1000 * self._handling.slip:.0f} mm"
        reason = "" if lost_at is None else f"the object slipped by more than {slip}"
        return Held(lost_at is None, reason, largest, touching, lost_at, self._squeeze)

    def _borne(self, ticks: int) -> Metric:
        """What share of its weight the fingertips have borne, a mean over so many ticks."""
        loads = np.mean(self._loads[-ticks:], axis=0)
        contacts, gravity = (loads[PARTIES.index(party), 2] for party in ("contacts", "gravity"))
        return Metric(float(contacts / -gravity)) if np.isfinite(loads).all() else Metric(None, "forces are not known")

    def _in_palm(self) -> Array:
        """Where the held part of the object is in the palm's frame (3,) [m]."""
        palm = self._world.palm()
        return np.asarray(palm.rotation.T @ (self._held_part() - palm.position))

    def _held_part(self) -> Array:
        """Where the part of the object is (3,) [m] that was between the contacts."""
        return np.asarray(self._truth.object_position + self._truth.object_rotation @ self._between)

    def _ticks(self, duration: float) -> int:
        return round(duration * self._world.info.rate)


class LiftGrade(Grade):
    """Whether a final grasp keeps its object when it is lifted and held."""

    name = "lift"
    about = "whether the object, squeezed and raised by the hand, stays in it"
    definition = (
        f"Lift: squeezed until the strongest fingertip presses with {TEST.squeeze:g} N and raised by "
        f"{100 * TEST.height:g} cm, the object moves by less than {1000 * TEST.slip:g} mm between the contacts."
    )
    passed = "kept"
    column = "kept when lifted"
    verdict = "kept"
    quantities: ClassVar[tuple[Quantity, ...]] = (Quantity("borne", "weight borne by the contacts when lifted"),)
    handles = True

    def test(self, grasp: Grasp) -> Test[None]:
        """Squeeze, lift and hold."""
        yield from grasp.once(Handled).lifted()

    def of(self, grasp: Grasp) -> Found:
        """Kept or not, and if not why, with what was measured."""
        missing = Held(False, grasp.missing, borne=Metric(None, grasp.missing))
        held = missing if grasp.missing else self.part(grasp.once(Handled))
        assert held is not None, "it is asked of a grasp that was tested"
        return dataclasses.asdict(held)

    def part(self, handled: Handled) -> Held | None:
        """The part of the test that is judged."""
        return handled.lift


class ShakeGrade(LiftGrade):
    """Whether a final grasp keeps its object when it is shaken after the lift."""

    name = "shake"
    about = "whether the object, lifted, stays in the hand when that is shaken along three axes"
    definition = (
        f"Shake: the same, shaken by {100 * TEST.amplitude:g} cm at {TEST.frequency:g} Hz "
        f"(up to {TEST.acceleration:.1f} m/s²) along three axes."
    )
    column = "kept when shaken"
    quantities = ()

    def test(self, grasp: Grasp) -> Test[None]:
        """Squeeze, lift, hold and shake."""
        yield from grasp.once(Handled).shaken()

    def part(self, handled: Handled) -> Held | None:
        """The part of the test that is judged."""
        return handled.shake
