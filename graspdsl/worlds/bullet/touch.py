"""What the fingertips feel: load cells read by intrinsic contact sensing, or the engine's exact contacts."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from graspdsl.arrays import Array, Flags
from graspdsl.hands.fingertips import SphereTip
from graspdsl.worlds.bullet.hand import BulletHand
from graspdsl.worlds.bullet.scene import Scene
from graspdsl.worlds.load_cell import sphere_contact


@dataclass(frozen=True, slots=True)
class TouchSettings:
    """How fingertips sense: ``load-cell`` or ``exact``; a contact begins above and ends below these forces [N]."""

    sensing: str = "load-cell"
    begins: float = 0.06
    ends: float = 0.03


class Reading(NamedTuple):
    """One tick's tactile reading; world frame but for ``local``, the contact points in the tips' link frames."""

    points: Array
    normals: Array
    forces: Array
    touching: Flags
    local: tuple[Array, ...]
    rotations: Array


class Fingertips:
    """The tactile sensors of all fingertips, with their memory: taring, touch hysteresis, the last normals."""

    def __init__(self, hand: BulletHand, scene: Scene, settings: TouchSettings, gravity: float) -> None:
        self._hand, self._scene, self._settings = hand, scene, settings
        self._weight = np.array([0.0, 0.0, -gravity])
        count = len(hand.tips)
        self._zero = np.zeros((count, 6))
        self._touching = np.zeros(count, dtype=bool)
        self._last_normal: list[Array | None] = [None] * count
        joints = list(hand.robot.joints)
        self._closing = [
            np.array([hand.robot.joints[j].closes if j in contact.finger else 0 for j in joints], dtype=float)
            for contact in hand.robot.hand.contacts.values()
        ]

    def tare(self) -> None:
        """Take the present reading, less the tips' own weight in this pose, as zero."""
        self._zero = np.zeros_like(self._zero)
        self._zero = np.array(self._loads(self._hand.tip_frames()))

    def _loads(self, frames: list[tuple[Array, Array]]) -> list[Array]:
        """The (6,) load that the object puts on each tip, about its sphere's centre, in the tip's frame."""
        loads = []
        for tip, (_, rotation), raw, zero in zip(
            self._hand.tips, frames, self._hand.cell_readings(), self._zero, strict=True
        ):
            # The joint answers what it holds up against: minus the object's load and the weight of the tip.
            weight = tip.mass * (rotation.T @ self._weight)
            force = -raw[:3] - weight
            centre_of_mass = tip.weight_lever
            moment = -raw[3:] + np.cross(centre_of_mass, -raw[:3])
            moment = moment - np.cross(centre_of_mass, weight)
            loads.append(np.concatenate([force, moment]) - zero)
        return loads

    def read(self) -> Reading:
        """Points, normals and forces of all contacts as this sensing gives them."""
        hand = self._hand
        frames = hand.tip_frames()
        exact = self._settings.sensing == "exact"
        if exact:
            points, normals, forces = self._scene.tip_contacts(hand)
            strengths = np.nan_to_num(np.linalg.norm(forces, axis=1))
        else:
            points, normals, forces = (np.full((len(frames), 3), np.nan) for _ in range(3))
            loads = self._loads(frames)
            strengths = np.array([np.linalg.norm(load[:3]) for load in loads])
        limit = np.where(self._touching, self._settings.ends, self._settings.begins)
        self._touching = strengths > limit
        rotations = np.array([rotation for _, rotation in frames])
        local = []
        for i, (tip, (origin, rotation)) in enumerate(zip(hand.tips, frames, strict=True)):
            place = tip.centre
            if self._touching[i]:
                if exact:
                    place = rotation.T @ (points[i] - origin)
                else:
                    radius = tip.shape.radius if isinstance(tip.shape, SphereTip) else 0.0
                    radial = sphere_contact(loads[i][:3], loads[i][3:], radius)
                    place = tip.centre + radial
                    points[i] = origin + rotation @ place
                    normals[i] = rotation @ radial / radius
                    forces[i] = -rotation @ loads[i][:3]
                self._last_normal[i] = normals[i]
            else:
                points[i], forces[i] = origin + rotation @ tip.centre, 0.0
                normals[i] = self._predicted_normal(i)
            local.append(place)
        return Reading(points, normals, forces, self._touching.copy(), tuple(local), rotations)

    def _predicted_normal(self, contact: int) -> Array:
        """Where a contact that does not touch will meet the surface: its last normal, or where its finger closes."""
        last = self._last_normal[contact]
        if last is not None:
            return last
        tip = self._hand.tips[contact]
        motion = self._hand.jacobians(tip, tip.centre, self._hand.all_joints())[0] @ self._closing[contact]
        direction: Array = motion / np.linalg.norm(motion)
        return direction
