"""The tactile readings of all fingertips: which touch, where, and what the others will meet."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from graspdsl.arrays import Array, Flags
from graspdsl.hands.descriptions import Robot
from graspdsl.spec.sensing import TactileSensor
from graspdsl.worlds.touch.fingertip_sensor import Clock, FingertipPhysics
from graspdsl.worlds.touch.sensors import sensor_for


class TipReading(NamedTuple):
    """One tick's tactile reading; world frame but for ``local``, the contact points in the tips' link frames."""

    points: Array
    normals: Array
    forces: Array
    touching: Flags
    local: tuple[Array, ...]
    rotations: Array


class Fingertips:
    """The tactile sensors of all fingertips, with the memory of the hand: touch hysteresis and the last normals.

    seed: of all that is random in the sensors.
    """

    def __init__(
        self,
        hand: FingertipPhysics,
        robot: Robot,
        spec: TactileSensor,
        gravity: float,
        clock: Clock,
        seed: int,
    ) -> None:
        self._hand, self._touch = hand, spec.touch
        self._sensor = sensor_for(spec)(spec, hand, gravity, clock, np.random.SeedSequence(seed))
        count = len(hand.tips)
        self._step = 0
        self._touching = np.zeros(count, dtype=bool)
        self._last_normal: list[Array | None] = [None] * count
        self._closing = [
            np.array([joint.closes if name in contact.finger else 0 for name, joint in robot.joints.items()], float)
            for contact in robot.hand.contacts.values()
        ]

    def advance(self, steps: int = 1) -> None:
        """So many steps of the engine have been made: take the samples that are due."""
        self._step += steps
        if self._sensor.due(self._step):
            self._sensor.sample(self._step)

    def note_rest(self) -> None:
        """Remember the present reading as one at rest, for taring."""
        self._sensor.note_rest(self._step)

    def tare(self) -> None:
        """Take the mean of the readings at rest as zero, or the present one if none were noted."""
        self._sensor.tare(self._step)

    def read(self) -> TipReading:
        """Points, normals and forces of all contacts as this sensing gives them."""
        frames = self._hand.frames()
        strengths = self._sensor.strengths(self._step, frames)
        self._touching = strengths > np.where(self._touching, self._touch.ends, self._touch.begins)
        points, normals, forces = np.zeros((3, len(frames), 3))
        local = []
        for i, (tip, (origin, rotation)) in enumerate(zip(self._hand.tips, frames, strict=True)):
            if self._touching[i]:
                place, points[i], normals[i], forces[i] = self._sensor.contact(i)
                self._last_normal[i] = normals[i]
            else:
                place, points[i] = tip.centre, origin + rotation @ tip.centre
                normals[i] = self._predicted_normal(i)
            local.append(place)
        rotations = np.array([rotation for _, rotation in frames])
        return TipReading(points, normals, forces, self._touching.copy(), tuple(local), rotations)

    def _predicted_normal(self, contact: int) -> Array:
        """Where a contact that does not touch will meet the surface.

        What the sensor knows of the surface ahead; else the last normal, or where the finger closes.
        """
        ahead = self._sensor.normal_ahead(contact)
        known = self._last_normal[contact] if ahead is None else ahead
        if known is not None:
            return known
        motion = self._hand.jacobian(contact, self._hand.tips[contact].centre) @ self._closing[contact]
        direction: Array = motion / np.linalg.norm(motion)
        return direction
