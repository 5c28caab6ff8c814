"""The simulator's own verdict on a grasp: squeeze, lift, hold and shake, and see whether the object stays."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from graspdsl.arrays import Array
from graspdsl.hands.descriptions import Robot
from graspdsl.quality.carrying import Carrier
from graspdsl.quality.metric import NO_CONTACTS
from graspdsl.quality.motions import rise, sway
from graspdsl.worlds.protocol import PalmWorld, WorldCrashError

AXES = np.eye(3)
UP = AXES[2]


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


@dataclass(frozen=True, slots=True)
class Held:
    """Whether a grasp kept its object through a part of the test, and if not why.

    displacement [m]: the largest, in the palm's frame, of the object's part between the contacts, None without a test;
    contacts: fingertips that touch at the end; lost_at [s]: when it had moved too far, from the beginning of the part,
    None if it never had; squeeze [N]: at the end of the ramp.
    """

    kept: bool
    reason: str
    displacement: float | None = None
    contacts: int = 0
    lost_at: float | None = None
    squeeze: float | None = None


def lift_and_shake(
    world: PalmWorld, robot: Robot, contacts: Sequence[int], handling: Handling, *, shake: bool = True
) -> tuple[Held, Held]:
    """Squeeze the object with these contacts, lift it, hold it and, with ``shake``, shake it.

    contacts: indices of fingertips that touch. Returns the verdicts on lift and shake. The world goes on from where it
    is and is not put back.
    """
    if not contacts:
        return Held(False, NO_CONTACTS), Held(False, NO_CONTACTS)
    try:
        test = _Test(world, robot, contacts, handling)
        lifted = test.lift()
    except WorldCrashError as error:
        lifted = Held(False, str(error))
    if not lifted.kept:
        return lifted, Held(False, "dropped before the shake")
    if not shake:
        return lifted, Held(False, "not shaken")
    try:
        return lifted, test.shake()
    except WorldCrashError as error:
        return lifted, Held(False, str(error))


class _Test:
    def __init__(self, world: PalmWorld, robot: Robot, contacts: Sequence[int], handling: Handling) -> None:
        self._world, self._contacts, self._handling = world, list(contacts), handling
        self._carrier = Carrier(world, robot, contacts)
        self._raised = np.zeros(3)
        truth = world.truth()
        between = truth.points[self._contacts].mean(axis=0) - truth.object_position
        self._between = truth.object_rotation.T @ between
        begun = self._carrier.squeeze
        for tick in range(1, self._ticks(handling.ramp) + 1):
            share = tick / self._ticks(handling.ramp)
            self._carrier.tick(np.zeros(3), begun + share * (handling.squeeze - begun))
        self._squeeze = self._carrier.squeeze

    def lift(self) -> Held:
        handling = self._handling
        rest = self._held_part()[2]

        def path(time: float) -> Array:
            return np.asarray(handling.height * rise(time / handling.rise) * UP)

        held = self._carry(path, handling.rise + handling.hold)
        self._raised = path(math.inf)
        risen = self._held_part()[2] - rest
        if held.kept and risen < handling.height - handling.slip:
            return dataclasses.replace(held, kept=False, reason="the object did not rise with the hand")
        return held

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
        before, largest, lost_at = self._in_palm(), 0.0, None
        for tick in range(1, self._ticks(duration) + 1):
            time = tick / self._world.info.rate
            self._carrier.tick(path(time), self._handling.squeeze)
            largest = max(largest, float(np.linalg.norm(self._in_palm() - before)))
            if not largest <= self._handling.slip:
                lost_at = time
                break
        points = self._world.truth().points[self._contacts]
        touching = int(np.isfinite(points).all(axis=1).sum())
        slip = f"{1000 * self._handling.slip:.0f} mm"
        reason = "" if lost_at is None else f"the object slipped by more than {slip}"
        return Held(lost_at is None, reason, largest, touching, lost_at, self._squeeze)

    def _in_palm(self) -> Array:
        """Where the held part of the object is in the palm's frame (3,) [m]."""
        palm = self._world.palm()
        return np.asarray(palm.rotation.T @ (self._held_part() - palm.position))

    def _held_part(self) -> Array:
        """Where the part of the object is (3,) [m] that was between the contacts."""
        truth = self._world.truth()
        return np.asarray(truth.object_position + truth.object_rotation @ self._between)

    def _ticks(self, duration: float) -> int:
        return round(duration * self._world.info.rate)
