"""The tactile readings of all fingertips: which touch, where, and what the others will meet."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np

from graspdsl.arrays import Array, Flags
from graspdsl.hands.descriptions import Robot
from graspdsl.spec.sensing import TactileSensor
from graspdsl.worlds.touch.fingertip_sensor import Clock, FingertipPhysics, TipFrames
from graspdsl.worlds.touch.sensors import sensor_for


class TipReading(NamedTuple):
    """One tick's tactile reading of N hands with k fingertips each.

    points, normals, forces: (N, k, 3), world frame; touching: (N, k); local: (N, k, 3), the contact points in the
    frames of the tips' links; rotations: (N, k, 3, 3) of these frames.
    """

    points: Array
    normals: Array
    forces: Array
    touching: Flags
    local: Array
    rotations: Array


Jacobians = Callable[[Array], Array]  # from places (N, k, 3) in the frames of the tips' links to (N, k, 3, n), linear


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
        self.hand, self.touch = hand, spec.touch
        self.sensor = sensor_for(spec)(spec, hand, gravity, clock, np.random.SeedSequence(seed))
        self.centres = np.array([tip.centre for tip in hand.tips])
        self.steps = 0
        self.touching = np.zeros(len(self.centres), dtype=bool)
        self.last_normals = np.full(self.centres.shape, np.nan)
        self.closing = np.array(
            [
                [joint.closes if name in contact.finger else 0 for name, joint in robot.joints.items()]
                for contact in robot.hand.contacts.values()
            ],
            dtype=float,
        )

    def advance(self, steps: int = 1) -> int:
        """So many steps of the engine have been made: take the samples that are due. Returns in how many steps the next
        are."""
        self.steps += steps
        if self.sensor.due(self.steps):
            self.sensor.sample(self.steps)
        return self.sensor.wait(self.steps)

    def note_rest(self) -> None:
        """Remember the present reading as one at rest, for taring."""
        self.sensor.note_rest(self.steps)

    def tare(self) -> None:
        """Take the mean of the readings at rest as zero, or the present one if none were noted."""
        self.sensor.tare(self.steps)


def read(hands: Sequence[Fingertips], frames: TipFrames, jacobians: Jacobians) -> TipReading:
    """Points, normals and forces of all contacts of alike hands side by side, as their sensing gives them."""
    kind, sensors, steps = type(hands[0].sensor), [hand.sensor for hand in hands], [hand.steps for hand in hands]
    touch, centres = hands[0].touch, hands[0].centres
    strengths = kind.strengths_of(sensors, steps, frames)
    touched = np.array([hand.touching for hand in hands])
    touching = strengths > np.where(touched, touch.ends, touch.begins)
    places = np.broadcast_to(centres, frames.origins.shape).copy()
    points = frames.origins + np.matvec(frames.rotations, centres)
    normals, forces = np.array([hand.last_normals for hand in hands]), np.zeros(points.shape)
    if touching.any():
        found = kind.contacts_of(sensors, touching, frames)
        places[touching], points[touching], normals[touching], forces[touching] = found
    if not touching.all():
        normals = np.where(touching[..., None], normals, _predicted(hands, normals, touching, jacobians))
    for hand, now, known in zip(hands, touching, normals, strict=True):
        hand.touching = now
        hand.last_normals = np.where(now[:, None], known, hand.last_normals)
    return TipReading(points, normals, forces, touching, places, frames.rotations)


def _predicted(hands: Sequence[Fingertips], last: Array, touching: Flags, jacobians: Jacobians) -> Array:
    """Where contacts that do not touch will meet the surface, (N, k, 3).

    What the sensor knows of the surface ahead; else the last normal, or where the finger closes.
    """
    normals = last
    if hands[0].sensor.sees_ahead:
        normals = last.copy()
        for row, tip in zip(*np.nonzero(~touching), strict=True):
            ahead = hands[row].sensor.normal_ahead(tip)
            normals[row, tip] = last[row, tip] if ahead is None else ahead
    unknown = np.isnan(normals[..., :1])
    if not (unknown & ~touching[..., None]).any():
        return normals
    motions = np.matvec(jacobians(np.broadcast_to(hands[0].centres, last.shape)), hands[0].closing)
    return np.where(unknown, motions / np.linalg.norm(motions, axis=-1, keepdims=True), normals)
