"""The grades there are, and a grasp graded by those that a spec asks for."""

from __future__ import annotations

from collections.abc import Container

from graspdsl.quality.ferrari_canny import FerrariCannyGrade
from graspdsl.quality.force_closure import ForceClosureGrade
from graspdsl.quality.grade import Found, Grade, Grasp
from graspdsl.quality.grasp_matrix import GraspMatrixGrade
from graspdsl.quality.lift_and_shake import LiftGrade, ShakeGrade
from graspdsl.worlds.protocol import Test

_BUILT_IN: tuple[Grade, ...] = (
    ForceClosureGrade(),
    FerrariCannyGrade(),
    GraspMatrixGrade(),
    LiftGrade(),
    ShakeGrade(),
)
GRADES: dict[str, Grade] = {grade.name: grade for grade in _BUILT_IN}


def tested(grasp: Grasp, asked: Container[str]) -> Test[None]:
    """What the grades of these names do with a grasp before they are asked, in the order of the table."""
    for name, grade in GRADES.items():
        if name in asked:
            yield from grade.test(grasp)


def graded(grasp: Grasp, asked: Container[str]) -> dict[str, Found]:
    """What the grades of these names say of a grasp, in the order of the table."""
    return {name: grade.of(grasp) for name, grade in GRADES.items() if name in asked}
