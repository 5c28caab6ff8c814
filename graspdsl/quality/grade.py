"""What a grade of a final grasp is: how it is asked for, what it says of a grasp, and how that is told."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property, partial
from typing import Any, ClassVar, TypeVar

import numpy as np

from graspdsl.arrays import Array
from graspdsl.hands.descriptions import Robot
from graspdsl.quality.contact_models import SoftFinger, contact_model
from graspdsl.quality.wrench_space import WrenchSpace, wrench_space
from graspdsl.spec.grading import RADIUS_OF_GYRATION, Grading
from graspdsl.worlds.protocol import PalmWorld, Test

NO_CONTACTS = "no contacts"
CRASHED = "the simulation failed"
REFERENCE = "the object's centre of mass"

Made = TypeVar("Made")
Found = Mapping[str, Any]  # what a grade says of one grasp, as plain data: it stands in the record of a trial


@dataclass(frozen=True, slots=True)
class Metric:
    """A value, with a reason where it is zero or None; an empty reason where it speaks for itself.

    Zero: measured, and there is nothing of it. None: there was nothing to measure.
    """

    value: float | None
    reason: str = ""


@dataclass(frozen=True, slots=True)
class Quantity:
    """A number that a grade finds, a :class:`Metric` under ``key``: its label, unit and number formats, that of a table
    and a brief one."""

    key: str
    label: str
    unit: str = ""
    form: str = ".3g"
    brief: str = ".2g"


@dataclass(frozen=True)
class Grasp:
    """The final grasp of a trial by the world's truth, of those of its contacts that touch.

    points, normals: (k, 3) [m], normals into the object; centre_of_mass: (3,) [m]; friction: between fingertips and
    object; torque_scale [m]: what moments are divided by, the same for all grasps of a run; grading: the spec's other
    conventions. world: to lift and shake the object with these ``contacts`` of the robot, which changes the world; None
    in a world without a palm. missing: why there is no grasp to grade, empty where there is one.
    """

    robot: Robot
    friction: float
    torque_scale: float
    points: Array = field(default_factory=partial(np.zeros, (0, 3)))
    normals: Array = field(default_factory=partial(np.zeros, (0, 3)))
    centre_of_mass: Array = field(default_factory=partial(np.zeros, 3))
    contacts: Sequence[int] = ()
    grading: Grading = field(default_factory=Grading)
    world: PalmWorld | None = None
    missing: str = ""
    _made: dict[Callable[[Grasp], Any], Any] = field(default_factory=dict, repr=False)

    @cached_property
    def wrenches(self) -> WrenchSpace:
        """The wrenches by which grades judge, moments about the object's centre of mass and over the torque scale."""
        given = self.grading
        model = contact_model(given.contact, len(self.points), self.friction, given.torsion, given.edges)
        return wrench_space(self.points, self.normals, model, reference=self.centre_of_mass, length=self.torque_scale)

    @property
    def conventions(self) -> Found:
        """By what a grade judges it, as plain data: contact model, None where there is nothing to judge, edges of a
        friction pyramid, torsion of a soft finger [m], and torque scale, in m and in words."""
        model, scale = self.wrenches.model, self.grading.torque_scale
        return {
            "model": None if self.missing else model.name,
            "edges": self.grading.edges,
            "torsion": model.torsion if isinstance(model, SoftFinger) and not self.missing else None,
            "length": self.torque_scale,
            "scale": "the object's radius of gyration" if scale == RADIUS_OF_GYRATION else "as the spec gives it",
        }

    def once(self, make: Callable[[Grasp], Made]) -> Made:
        """What several grades share of a grasp, made for the first that asks."""
        if make not in self._made:
            self._made[make] = make(self)
        found: Made = self._made[make]
        return found


class Grade(ABC):
    """A way to grade final grasps: passed or not, numbers, or both.

    name: under ``evaluate`` and in records; about: a line for ``list``; definition: what a page says of it, in the
    terms of the literature. passed: the key of its yes or no, "" for none, beside which stands the ``reason`` of a no;
    column: what a console calls the grasps that passed, or its numbers. verdict: in which of the verdicts that are set
    side by side its yes or no counts, "" for none; of two grades the later one of the table counts. quantities: the
    numbers that it finds. by_friction: whether the scene's friction has a part in it; handles: whether the world must
    lift a free object with a hand.
    """

    name: ClassVar[str]
    about: ClassVar[str]
    definition: ClassVar[str]
    title: ClassVar[str] = ""
    passed: ClassVar[str] = ""
    column: ClassVar[str] = ""
    verdict: ClassVar[str] = ""
    quantities: ClassVar[tuple[Quantity, ...]] = ()
    by_friction: ClassVar[bool] = False
    handles: ClassVar[bool] = False

    @property
    def key(self) -> str:
        """Its key in the JSON of a summary."""
        return self.name.replace("-", "_")

    @property
    def label(self) -> str:
        """What a page calls it."""
        return self.title or self.name.replace("-", " ")

    def test(self, grasp: Grasp) -> Test[None]:
        """What is done with a grasp that is not missing in its world before ``of`` is asked: nothing."""
        del grasp
        yield from ()

    @abstractmethod
    def of(self, grasp: Grasp) -> Found:
        """What it says of a grasp, as plain data; where the grasp is missing: not passed, not measured, for that
        reason."""
