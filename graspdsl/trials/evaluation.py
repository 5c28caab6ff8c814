"""The grades of a trial's final grasp, asked for by ``evaluate`` in a spec."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from graspdsl.hands.descriptions import Robot
from graspdsl.quality.grade import CRASHED, NO_CONTACTS, Found, Grasp
from graspdsl.quality.grades import graded
from graspdsl.worlds.protocol import PalmWorld, Witness

Quality = Mapping[str, Found]


@dataclass(frozen=True, slots=True)
class Evaluation:
    """Grades grasps of a robot. ``grades``: those of a spec's ``evaluate``; friction: between fingertips and object."""

    grades: Sequence[str]
    friction: float
    robot: Robot

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
        grasp = Grasp(
            self.robot,
            self.friction,
            truth.points[touching],
            truth.normals[touching],
            truth.object_position,
            touching,
            world if isinstance(world, PalmWorld) else None,
        )
        return graded(grasp, self.grades)

    def of_nothing(self, reason: str) -> Quality:
        """The grades of a trial without a grasp to grade: none is closed, measured or held, for this reason."""
        return graded(Grasp(self.robot, self.friction, missing=reason), self.grades)
