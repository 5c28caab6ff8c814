"""Fingertips of no engine: balls that are turned, pressed, dented and moved by hand."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cache

import numpy as np

from graspdsl.arrays import Array
from graspdsl.hands.fingertips import SphereTip
from graspdsl.spec.scene import GRAVITY
from graspdsl.worlds.touch.compliance import force_of_dent
from graspdsl.worlds.touch.fingertip_sensor import Clock, Fingertip, FingertipSensor

RADIUS = 0.01  # m
STEPS = 10  # of the engine a tick
CLOCK = Clock(500.0, 50.0)
AWAY = 0.01  # m, of an object that is not touched
TIP = Fingertip(
    SphereTip(centre=(0.004, -0.002, 0.001), radius=RADIUS),
    np.array([0.004, -0.002, 0.001]),
    0.02,
    np.array([0.001, 0.002, 0.0]),
)


@dataclass
class PressedBalls:
    """Fingertips that press on an object with ``forces`` [N], each along its ``inward`` (k, 3), without friction, and
    dented by as much as their compliance says; a FingertipPhysics."""

    forces: list[float]
    inward: Array
    places: Sequence[tuple[Array, Array]]
    tips: Sequence[Fingertip] = field(init=False)

    def __post_init__(self) -> None:
        self.tips = [TIP] * len(self.forces)

    @classmethod
    def drawn(cls, *forces: float, seed: int = 0) -> PressedBalls:
        """Turned and placed at random."""
        from scipy.spatial.transform import Rotation

        random, count = np.random.default_rng(seed), len(forces)
        inward = random.normal(size=(count, 3))
        inward /= np.linalg.norm(inward, axis=1, keepdims=True)
        turns = Rotation.random(count, random_state=seed).as_matrix()
        return cls(list(forces), inward, list(zip(random.normal(scale=0.1, size=(count, 3)), turns, strict=True)))

    @property
    def points(self) -> Array:
        """Where they touch, or are nearest to what they do not touch, (k, 3) in the world."""
        centres = np.array([origin + rotation @ TIP.centre for origin, rotation in self.places])
        return np.asarray(centres + RADIUS * self.inward)

    def frames(self) -> Sequence[tuple[Array, Array]]:
        """Where they are."""
        return self.places

    def wrenches(self) -> Array:
        """What holds up their weight and the object's force, about their centres of mass, in their frames."""
        found = []
        for force, inward, (_, rotation) in zip(self.forces, self.inward, self.places, strict=True):
            load = rotation.T @ (-force * inward)
            weight = rotation.T @ np.array([0.0, 0.0, -GRAVITY * TIP.mass])
            lever = RADIUS * (rotation.T @ inward) - TIP.weight_lever
            found.append([*-(load + weight), *-np.cross(lever, load)])
        return np.array(found)

    def contacts(self) -> tuple[Array, Array, Array]:
        """The truth."""
        pressed = np.array(self.forces)[:, None] > 0.0
        found = (self.points, self.inward, np.array(self.forces)[:, None] * self.inward)
        points, normals, forces = (np.where(pressed, part, np.nan) for part in found)
        return points, normals, forces

    def presses(self) -> list[tuple[Array, Array]]:
        """One contact, where there is a force."""
        pairs = zip(self.points, self.forces, strict=True)
        return [(p[None], np.array([f])) if f else (np.zeros((0, 3)), np.zeros(0)) for p, f in pairs]

    def nearest(self, within: float) -> list[tuple[float, Array] | None]:
        """So deep that the dent makes the force; a centimetre away without one."""
        dents = map(_dent, self.forces)
        return [(-d, point) if -d < within else None for d, point in zip(dents, self.points, strict=True)]


@cache
def _dent(force: float) -> float:
    """How deep [m] a force [N] dents a tip."""
    depths = np.linspace(0.0, 0.01, 100_001)
    return float(np.interp(force, force_of_dent(depths), depths)) if force else -AWAY


def run(sensor: FingertipSensor, first: int, ticks: int = 1) -> int:
    """Take the samples that are due in some ticks after a step; the step they end with."""
    for step in range(first + 1, first + STEPS * ticks + 1):
        if sensor.due(step):
            sensor.sample(step)
    return first + STEPS * ticks
