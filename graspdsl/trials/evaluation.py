"""The grades of a trial's final grasp, asked for by ``evaluate`` in a spec."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from graspdsl.arrays import Array
from graspdsl.hands.descriptions import Robot
from graspdsl.quality.grades import graded_ferrari_canny, graded_force_closure, grasp_wrenches
from graspdsl.quality.lift_and_shake import Handling, Held, lift_and_shake
from graspdsl.quality.metric import CRASHED, NO_CONTACTS
from graspdsl.worlds.protocol import PalmWorld, Witness

HANDLING = ("lift", "shake")
NOWHERE = np.zeros((0, 3))
Quality = dict[str, dict[str, Any]]


@dataclass(frozen=True, slots=True)
class Evaluation:
    """Grades grasps of a robot. ``grades``: those of a spec's ``evaluate``; friction: between fingertips and object."""

    grades: Sequence[str]
    friction: float
    robot: Robot
    handling: Handling = field(default_factory=Handling)

    def of(self, world: Witness, contacts: Sequence[int]) -> Quality:
        """The grades of the grasp that a world is in, by its truth, of those of the contacts that touch.

        To lift and shake the object changes the world.
        """
        if not self.grades:
            return {}
        truth = world.truth()
        if not np.isfinite(truth.object_position).all():
            return self.of_nothing(CRASHED)
        touching = [contact for contact in contacts if np.isfinite(truth.points[contact]).all()]
        if not touching:
            return self.of_nothing(NO_CONTACTS)
        measured = self._in_wrench_space(truth.points[touching], truth.normals[touching], truth.object_position)
        return {**measured, **self._handled(world, touching)}

    def of_nothing(self, reason: str) -> Quality:
        """The grades of a trial without a grasp to grade: none is closed, measured or held, for this reason."""
        quality = self._in_wrench_space(NOWHERE, NOWHERE, np.zeros(3))
        if "force-closure" in quality:
            quality["force-closure"]["reason"] = reason
        if "ferrari-canny" in quality:
            quality["ferrari-canny"].update({name: {"value": None, "reason": reason} for name in ("epsilon", "volume")})
        dropped = dataclasses.asdict(Held(False, reason))
        return {**quality, **{grade: dropped for grade in HANDLING if grade in self.grades}}

    def _handled(self, world: Witness, contacts: Sequence[int]) -> Quality:
        asked = [grade for grade in HANDLING if grade in self.grades]
        if not asked or not isinstance(world, PalmWorld):
            return {}
        verdicts = lift_and_shake(world, self.robot, contacts, self.handling, shake="shake" in asked)
        return {
            grade: dataclasses.asdict(held) for grade, held in zip(HANDLING, verdicts, strict=True) if grade in asked
        }

    def _in_wrench_space(self, points: Array, normals: Array, centre_of_mass: Array) -> Quality:
        space = grasp_wrenches(points, normals, centre_of_mass, self.friction)
        quality: Quality = {}
        if "force-closure" in self.grades:
            quality["force-closure"] = graded_force_closure(space, len(points))
        if "ferrari-canny" in self.grades:
            quality["ferrari-canny"] = graded_ferrari_canny(space)
        return quality
