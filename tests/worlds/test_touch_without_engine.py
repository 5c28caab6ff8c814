"""Every tactile sensor of the table on a fingertip of no engine: a ball that is pressed, dented and moved by hand."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from graspdsl.arrays import Array
from graspdsl.hands.fingertips import SphereTip
from graspdsl.worlds.touch.compliance import force_of_dent
from graspdsl.worlds.touch.fingertip_sensor import Clock, FingertipSensor
from graspdsl.worlds.touch.sensors import TACTILE_SENSORS

RADIUS = 0.01  # m
GRAVITY = 9.81
CLOCK = Clock(500.0, 50.0)
STEPS = 10  # of the engine a tick
EACH_SENSOR = pytest.mark.parametrize("sensor", TACTILE_SENSORS.values(), ids=TACTILE_SENSORS)


@dataclass(frozen=True)
class Tip:
    """A ball on its link; its centre of mass is beside its centre."""

    shape: SphereTip
    centre: Array
    mass: float
    weight_lever: Array


@dataclass
class PressedBall:
    """One fingertip, which presses on an object with a force [N] along ``inward`` (3,), dented by as much as its
    compliance says."""

    inward: Array
    force: float
    rotation: Array
    origin: Array

    @property
    def tips(self) -> list[Tip]:
        """The one there is."""
        centre = np.array([0.004, -0.002, 0.001])
        return [Tip(SphereTip(centre=tuple(centre), radius=RADIUS), centre, 0.02, np.array([0.001, 0.002, 0.0]))]

    def frames(self) -> list[tuple[Array, Array]]:
        """Where it is."""
        return [(self.origin, self.rotation)]

    @property
    def point(self) -> Array:
        """Where it touches, in the world."""
        return self.origin + self.rotation @ self.tips[0].centre + RADIUS * self.inward

    def wrenches(self) -> Array:
        """What holds up its weight and the object's force, about its centre of mass, in its frame."""
        [tip] = self.tips
        load = self.rotation.T @ (-self.force * self.inward)
        weight = self.rotation.T @ np.array([0.0, 0.0, -GRAVITY * tip.mass])
        lever = RADIUS * (self.rotation.T @ self.inward) - tip.weight_lever
        return np.array([[*-(load + weight), *-np.cross(lever, load)]])

    def contacts(self) -> tuple[Array, Array, Array]:
        """The truth."""
        if self.force == 0.0:
            return tuple(np.full((3, 1, 3), np.nan))
        return self.point[None], self.inward[None], self.force * self.inward[None]

    def presses(self) -> list[tuple[Array, Array]]:
        """One contact, where there is a force."""
        return [(self.point[None], np.array([self.force]))] if self.force else [(np.zeros((0, 3)), np.zeros(0))]

    def nearest(self, within: float) -> list[tuple[float, Array] | None]:
        """So deep that the dent makes the force; a centimetre away without one."""
        depths = np.linspace(0.0, 0.01, 100_001)
        dent = float(np.interp(self.force, force_of_dent(depths), depths)) if self.force else -0.01
        return [(-dent, self.point)] if -dent < within else [None]

    def jacobian(self, tip: int, place: Array) -> Array:
        """It does not move."""
        del tip, place
        return np.zeros((3, 0))


def ball(force: float, seed: int = 0) -> PressedBall:
    """Turned and placed at random."""
    random = np.random.default_rng(seed)
    inward = random.normal(size=3)
    rotation = Rotation.random(random_state=seed).as_matrix()
    return PressedBall(inward / np.linalg.norm(inward), force, rotation, random.normal(scale=0.1, size=3))


def rested(sensor: type[FingertipSensor], hand: PressedBall) -> FingertipSensor:
    """A perfect sensor after a tick at rest, without a force, and tared."""
    force, hand.force = hand.force, 0.0
    made = sensor(sensor.model(), hand, GRAVITY, CLOCK, np.random.SeedSequence(1))
    for step in range(1, STEPS + 1):
        if made.due(step):
            made.sample(step)
    made.tare(STEPS)
    hand.force = force
    return made


@EACH_SENSOR
@pytest.mark.parametrize("seed", range(3))
def test_it_feels_where_and_how_strongly_it_is_pressed(sensor: type[FingertipSensor], seed: int) -> None:
    hand = ball(0.8, seed)
    made = rested(sensor, hand)
    for step in range(STEPS + 1, 2 * STEPS + 1):
        if made.due(step):
            made.sample(step)
    [strength] = made.strengths(2 * STEPS, hand.frames())
    found = made.contact(0)
    assert strength == pytest.approx(0.8, abs=0.03)  # of a skin, what the window about the strongest taxel holds
    np.testing.assert_allclose(found.point, hand.point, atol=5e-4)
    np.testing.assert_allclose(found.normal, hand.inward, atol=0.06)
    np.testing.assert_allclose(found.force, 0.8 * hand.inward, atol=0.06)
    np.testing.assert_allclose(hand.origin + hand.rotation @ found.place, found.point, atol=1e-12)


@EACH_SENSOR
def test_it_feels_nothing_where_nothing_presses(sensor: type[FingertipSensor]) -> None:
    """Not even the weight of the tip; what it knows ahead is the normal that it would meet."""
    hand = ball(0.0)
    made = rested(sensor, hand)
    assert made.strengths(STEPS, hand.frames()) == pytest.approx([0.0], abs=1e-12)
    ahead = made.normal_ahead(0)
    if ahead is not None:
        np.testing.assert_allclose(ahead, hand.inward, atol=1e-9)
