"""The simulator's own verdict on a grasp: squeeze, lift, hold and shake, and see whether the object stays."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import ClassVar

import numpy as np

from graspdsl.arrays import Array
from graspdsl.quality.carrying import Carrier
from graspdsl.quality.grade import Found, Grade, Grasp, Metric, Quantity
from graspdsl.worlds.protocol import PARTIES, Truth, WorldCrashError

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

    The world goes on from where it is and is not put back.
    """

    def __init__(self, grasp: Grasp, handling: Handling = TEST) -> None:
        self._grasp, self._handling = grasp, handling

    @cached_property
    def lift(self) -> Held:
        """Whether the object was kept when lifted and held."""
        return self._kept(_Test.lift)

    @cached_property
    def shake(self) -> Held:
        """Whether it was kept when shaken after that."""
        return self._kept(_Test.shake) if self.lift.kept else Held(False, "dropped before the shake")

    @cached_property
    def _test(self) -> _Test:
        return _Test(self._grasp, self._handling)

    def _kept(self, part: Callable[[_Test], Held]) -> Held:
        try:
            return part(self._test)
        except WorldCrashError as error:
            return Held(False, str(error), borne=Metric(None, str(error)))


class _Test:
    def __init__(self, grasp: Grasp, handling: Handling) -> None:
        assert grasp.world is not None
        self._world, self._contacts, self._handling = grasp.world, list(grasp.contacts), handling
        self._carrier = Carrier(self._world, grasp.robot, self._contacts)
        self._raised, self._loads = np.zeros(3), list[Array]()
        truth = self._world.truth()
        between = truth.points[self._contacts].mean(axis=0) - truth.object_position
        self._between = truth.object_rotation.T @ between
        begun = self._carrier.squeeze
        for tick in range(1, self._ticks(handling.ramp) + 1):
            share = tick / self._ticks(handling.ramp)
            self._carrier.tick(np.zeros(3), begun + share * (handling.squeeze - begun))
        self._squeeze = self._carrier.squeeze

    def lift(self) -> Held:
        handling = self._handling
        rest = self._held_part(self._world.truth())[2]

        def path(time: float) -> Array:
            return np.asarray(handling.height * rise(time / handling.rise) * UP)

        held = self._carry(path, handling.rise + handling.hold)
        self._raised = path(math.inf)
        risen = self._held_part(self._world.truth())[2] - rest
        if held.kept and risen < handling.height - handling.slip:
            held = dataclasses.replace(held, kept=False, reason="the object did not rise with the hand")
        borne = self._borne(self._ticks(handling.hold)) if held.kept else Metric(None, held.reason)
        return dataclasses.replace(held, borne=borne)

    def shake(self) -> Held:
        handling = self._handling
        each = handling.cycles / handling.frequency

        def path(time: float) -> Array:
            axis = min(2, int(time / each))
            cycles = handling.frequency * (time - axis * each)
            return np.asarray(self._raised + handling.amplitude * sway(cycles, handling.cycles) * AXES[axis])

        return self._carry(path, 3.0 * each)

    def _carry(self, path: Callable[[float], Array], duration: float) -> Held:
        """Follow a path; stop when the object has moved too far in the hand."""
        before, largest, lost_at = self._in_palm(self._world.truth()), 0.0, None
        for tick in range(1, self._ticks(duration) + 1):
            time = tick / self._world.info.rate
            self._carrier.tick(path(time), self._handling.squeeze)
            truth = self._world.truth()
            self._loads.append(truth.loads)
            largest = max(largest, float(np.linalg.norm(self._in_palm(truth) - before)))
            if not largest <= self._handling.slip:
                lost_at = time
                break
        points = self._world.truth().points[self._contacts]
        touching = int(np.isfinite(points).all(axis=1).sum())
        slip = f"{1000 * self._handling.slip:.0f} mm"
        reason = "" if lost_at is None else f"the object slipped by more than {slip}"
        return Held(lost_at is None, reason, largest, touching, lost_at, self._squeeze)

    def _borne(self, ticks: int) -> Metric:
        """What share of its weight the fingertips have borne, a mean over so many ticks."""
        loads = np.mean(self._loads[-ticks:], axis=0)
        contacts, gravity = (loads[PARTIES.index(party), 2] for party in ("contacts", "gravity"))
        return Metric(float(contacts / -gravity)) if np.isfinite(loads).all() else Metric(None, "forces are not known")

    def _in_palm(self, truth: Truth) -> Array:
        """Where the held part of the object is in the palm's frame (3,) [m]."""
        palm = self._world.palm()
        return np.asarray(palm.rotation.T @ (self._held_part(truth) - palm.position))

    def _held_part(self, truth: Truth) -> Array:
        """Where the part of the object is (3,) [m] that was between the contacts."""
        return np.asarray(truth.object_position + truth.object_rotation @ self._between)

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

    def of(self, grasp: Grasp) -> Found:
        """Kept or not, and if not why, with what was measured."""
        missing = Held(False, grasp.missing, borne=Metric(None, grasp.missing))
        return dataclasses.asdict(missing if grasp.missing else self.part(grasp.once(Handled)))

    def part(self, handled: Handled) -> Held:
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

    def part(self, handled: Handled) -> Held:
        """The part of the test that is judged."""
        return handled.shake
