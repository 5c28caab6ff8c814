"""The grades of a trial's final grasp, asked for by ``evaluate`` in a spec."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from graspdsl.compiler.program import Program
from graspdsl.quality.grade import CRASHED, NO_CONTACTS, Found, Grasp
from graspdsl.quality.grades import graded, tested
from graspdsl.worlds.protocol import PalmWorld, Test, Witness

Quality = Mapping[str, Found]


class Evaluation:
    """Grades grasps of a program's trials, by its ``evaluate`` and ``grading``; torque_scale [m]: the same for all."""

    def __init__(self, program: Program) -> None:
        spec = program.spec
        self._grades, self._robot, self._friction = spec.evaluate, program.robot, spec.scene.friction
        self._grading, scale = spec.grading, spec.grading.torque_scale
        self.torque_scale = program.body.shape.solid.radius_of_gyration if isinstance(scale, str) else scale

    def of(self, world: Witness, contacts: Sequence[int]) -> Test[Quality]:
        """The grades of the grasp that a world is in, by its truth, of those of the contacts that touch.

        To lift and shake the object changes the world.
        """
        if not self._grades:
            return {}
        truth = world.truth()
        if not np.isfinite(truth.object_position).all():
            return self.of_nothing(CRASHED)
        touching = [contact for contact in contacts if np.isfinite(truth.points[contact]).all()]
        if not touching:
            return self.of_nothing(NO_CONTACTS)
        grasp = Grasp(
            self._robot,
            self._friction,
            self.torque_scale,
            truth.points[touching],
            truth.normals[touching],
            truth.object_position,
            touching,
            self._grading,
            world if isinstance(world, PalmWorld) else None,
        )
        yield from tested(grasp, self._grades)
        return graded(grasp, self._grades)

    def of_nothing(self, reason: str) -> Quality:
        """The grades of a trial without a grasp to grade: none is closed, measured or held, for this reason."""
        grasp = Grasp(self._robot, self._friction, self.torque_scale, grading=self._grading, missing=reason)
        return graded(grasp, self._grades)
