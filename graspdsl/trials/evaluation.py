"""The grades of a trial's final grasp, asked for by ``evaluate`` in a spec."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from graspdsl.arrays import Array
from graspdsl.quality.grades import graded_ferrari_canny, graded_force_closure, grasp_wrenches
from graspdsl.trials.stage import WitnessedWorld

NOWHERE = np.zeros((0, 3))
Quality = dict[str, dict[str, Any]]


@dataclass(frozen=True, slots=True)
class Evaluation:
    """Grades grasps. ``grades``: those of a spec's ``evaluate``; friction: between fingertips and object."""

    grades: Sequence[str]
    friction: float

    def of(self, world: WitnessedWorld, contacts: Sequence[int]) -> Quality:
        """The grades of the grasp that a world is in, by its truth, of those of the contacts that touch."""
        if not self.grades:
            return {}
        truth = world.truth()
        touching = [contact for contact in contacts if np.isfinite(truth.points[contact]).all()]
        if not touching or not np.isfinite(truth.object_position).all():
            return self.of_nothing()
        return self._in_wrench_space(truth.points[touching], truth.normals[touching], truth.object_position)

    def of_nothing(self) -> Quality:
        """The grades of a trial that came to no contact."""
        return self._in_wrench_space(NOWHERE, NOWHERE, np.zeros(3))

    def _in_wrench_space(self, points: Array, normals: Array, centre_of_mass: Array) -> Quality:
        space = grasp_wrenches(points, normals, centre_of_mass, self.friction)
        quality: Quality = {}
        if "force-closure" in self.grades:
            quality["force-closure"] = graded_force_closure(space, len(points))
        if "ferrari-canny" in self.grades:
            quality["ferrari-canny"] = graded_ferrari_canny(space)
        return quality
