"""The contract of grades."""

from __future__ import annotations

import json
import re
from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from graspdsl.basis.rotations import exponential
from graspdsl.contracts.drawing import generator, unit_vectors
from graspdsl.contracts.rule import Breach, contract
from graspdsl.declared import misdeclared
from graspdsl.hands.descriptions import robot
from graspdsl.quality.grade import Found, Grade, Grasp, Quantity
from graspdsl.quality.grades import GRADES
from graspdsl.spec.grading import ContactKind, Grading

ROBOT = robot("barrett", "gantry")
REASON = "it rains"
FRICTION = 0.4
TORQUE_SCALE = 0.05  # m
TORSION = 0.002  # m
LARGER = 1.7
COUNTS = (1, 2, 3, 4)  # of contacts
CONTACTS: tuple[ContactKind, ...] = ("hard", "soft-finger", "frictionless")
ALLOWED = 1e-6  # of a number, when the whole grasp is somewhere else


def declared(grade: Grade) -> Iterator[Breach]:
    """What a grade says of itself is there, and of the right type."""
    yield from misdeclared(grade, Grade)


def table(grade: Grade) -> Iterator[Breach]:
    """A grade is found by its own name."""
    if GRADES.get(grade.name) is not grade:
        found = type(GRADES[grade.name]).__name__ if grade.name in GRADES else "nothing"
        yield f"{grade.name} names {found} in the table", f"enter it as {grade.name}"


def told(grade: Grade) -> Iterator[Breach]:
    """Its line for lists ends without a full stop, its definition with one."""
    if not grade.about or "\n" in grade.about or grade.about.endswith("."):
        yield f"its line for lists is {grade.about!r}", "write about in one line, without a full stop"
    if not grade.definition.endswith("."):
        yield "its definition is no sentence", "say what a page says of it, with a full stop"


def keys(grade: Grade) -> Iterator[Breach]:
    """Its name is words joined by -, its column has a heading, and its numbers have keys of their own."""
    if not re.fullmatch(r"[a-z]+(-[a-z]+)*", grade.name):
        yield f"its name is {grade.name!r}", "use small letters, words joined by -"
    if not grade.column:
        yield "what a console calls it is not said", "give it a column"
    own = [quantity.key for quantity in grade.quantities]
    if len({*own, grade.passed, "reason"} - {""}) != len(own) + bool(grade.passed) + 1:
        yield "two of its numbers have one key", "give each a key of its own"
    for form in (form for quantity in grade.quantities for form in (quantity.form, quantity.brief)):
        format(1.0, form)  # raises for one that is none


def something(grade: Grade) -> Iterator[Breach]:
    """It says yes or no, or a number."""
    if not grade.passed and not grade.quantities:
        yield "it says neither yes or no nor a number", "say the key of its yes in 'passed', or its 'quantities'"


def missing(grade: Grade) -> Iterator[Breach]:
    """Of a trial without a grasp: not passed and not measured, for the reason that is given."""
    found = grade.of(Grasp(ROBOT, FRICTION, TORQUE_SCALE, missing=REASON))
    if grade.passed and (found.get(grade.passed), found.get("reason")) != (False, REASON):
        said = {key: found.get(key) for key in (grade.passed, "reason")}
        yield f"of a missing grasp it says {said}", f"say {grade.passed} False, and the reason that grasp.missing gives"
    for quantity in grade.quantities:
        if found.get(quantity.key) != {"value": None, "reason": REASON}:
            hint = "say value None, and the reason of grasp.missing"
            yield f"of a missing grasp it says {quantity.key} {found.get(quantity.key)}", hint


def plain(grade: Grade) -> Iterator[Breach]:
    """What it says is plain data, the same after it was written as JSON: it stands in the record of a trial."""
    for found in [grade.of(Grasp(ROBOT, FRICTION, TORQUE_SCALE, missing=REASON)), *_found(grade)]:
        try:
            same = json.loads(json.dumps(found, allow_nan=False)) == found
        except (TypeError, ValueError) as error:
            yield f"what it says is no plain data: {error}", "use float(…), bool(…), text, lists; None for no number"
            return
        if not same:
            yield "what it says is something else after it was written", "use lists, not tuples, and text for keys"
            return


def complete(grade: Grade) -> Iterator[Breach]:
    """It says yes or no and each of its numbers of any grasp, and why where there is a no, or no number."""
    for found in _found(grade):
        if grade.passed and not isinstance(found.get(grade.passed), bool):
            yield f"it says {grade.passed} {found.get(grade.passed)!r}", "say True or False"
            return
        if grade.passed and not found[grade.passed] and not _is_text(found.get("reason")):
            yield "it does not say why a grasp has not passed", "say it under 'reason', \"\" where it has"
            return
        for quantity in grade.quantities:
            metric = found.get(quantity.key)
            if not isinstance(metric, dict) or set(metric) != {"value", "reason"}:
                yield f"it says {quantity.key} {metric!r}", "say {'value': …, 'reason': …}, as a Metric has them"
                return
            if metric["value"] is None and not _is_text(metric["reason"]):
                yield f"it does not say why there is no {quantity.key}", "say it under 'reason'"
                return


def same_again(grade: Grade) -> Iterator[Breach]:
    """The same grasp gets the same grade, and stays as it is."""
    for grasp, same in zip(_grasps(grade), _grasps(grade), strict=True):
        found = grade.of(grasp)
        given = ("points", "normals", "centre_of_mass")
        if not all(np.array_equal(getattr(grasp, name), getattr(same, name)) for name in given):
            yield "it changes the grasp", "make new arrays: no out=, no +="
            return
        if grade.of(same) != found:
            yield "it says something else of the same grasp", "keep nothing from one grasp to the next"
            return


def anywhere(grade: Grade) -> Iterator[Breach]:
    """A grasp that is turned and moved as a whole, with the object, gets the same grade."""
    turn, way = exponential(np.array([0.4, -1.1, 0.7])), np.array([0.3, -0.2, 0.5])
    for grasp, same in zip(_grasps(grade), _grasps(grade), strict=True):
        elsewhere = replace(
            same,
            points=same.points @ turn.T + way,
            normals=same.normals @ turn.T,
            centre_of_mass=turn @ same.centre_of_mass + way,
        )
        if not _alike(grade, grade.of(grasp), grade.of(elsewhere)):
            yield (
                "it says something else of a grasp that is turned and moved with its object",
                "use no axes of the world",
            )
            return


def friction(grade: Grade) -> Iterator[Breach]:
    """Friction has a part in it only where it says so."""
    if grade.by_friction:
        return
    for grasp, same in zip(_grasps(grade), _grasps(grade), strict=True):
        if not _alike(grade, grade.of(grasp), grade.of(replace(same, friction=2.0 * FRICTION))):
            yield "it depends on friction, and does not say so", "say by_friction = True"
            return


def units(grade: Grade) -> Iterator[Breach]:
    """A yes, and a number without a unit, are the same in any unit of length."""
    plain = [quantity for quantity in grade.quantities if not quantity.unit]
    for grasp, same in zip(_grasps(grade), _grasps(grade), strict=True):
        larger = replace(
            same,
            torque_scale=LARGER * same.torque_scale,
            points=LARGER * same.points,
            centre_of_mass=LARGER * same.centre_of_mass,
            grading=same.grading.model_copy(update={"torsion": LARGER * TORSION}),
        )
        if not _alike(grade, grade.of(grasp), grade.of(larger), plain):
            yield (
                f"it says something else when all lengths, the torque scale too, are {LARGER:g} times as large",
                "divide moments by grasp.torque_scale, or give the number its unit",
            )
            return


RULES = contract(
    declared,
    table,
    told,
    keys,
    something,
    missing,
    plain,
    complete,
    same_again,
    anywhere,
    units,
    friction,
    wording=(told,),
)


def _grasps(grade: Grade) -> Iterator[Grasp]:
    """Contacts on an ellipsoid, one to four, the same for each run; none for a grade that needs a world."""
    random, axes = generator(), np.array([0.03, 0.04, 0.06])
    for count in () if grade.handles else COUNTS:
        for contact in CONTACTS:
            on_ball = unit_vectors(random, count)
            inward = -on_ball / axes
            yield Grasp(
                ROBOT,
                FRICTION,
                TORQUE_SCALE,
                on_ball * axes,
                inward / np.linalg.norm(inward, axis=1, keepdims=True),
                0.01 * random.normal(size=3),
                tuple(range(count)),
                Grading(torsion=TORSION, contact=contact),
            )


def _found(grade: Grade) -> Iterator[Found]:
    return (grade.of(grasp) for grasp in _grasps(grade))


def _is_text(value: Any) -> bool:
    return isinstance(value, str) and bool(value)


def _alike(grade: Grade, one: Found, other: Found, quantities: Sequence[Quantity] | None = None) -> bool:
    """Whether both say the same, numbers to a relative ALLOWED, of these quantities or of all."""
    if grade.passed and one[grade.passed] != other[grade.passed]:
        return False
    told = grade.quantities if quantities is None else quantities
    pairs = [(one[quantity.key]["value"], other[quantity.key]["value"]) for quantity in told]
    return all(
        a is b if a is None or b is None else bool(np.isclose(a, b, rtol=ALLOWED, atol=ALLOWED)) for a, b in pairs
    )
