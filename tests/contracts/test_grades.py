"""Every grade keeps each rule, and each rule is seen to be broken."""

from __future__ import annotations

from dataclasses import replace
from typing import Any, ClassVar

import numpy as np
import pytest
from graspdsl_stranger.grade import IsotropyGrade

from graspdsl.contracts.grades import RULES
from graspdsl.contracts.rule import Rule
from graspdsl.quality.grade import Found, Grade, Grasp
from graspdsl.quality.grades import GRADES

from .breaking import broken

SLOW = [pytest.param(name, marks=pytest.mark.slow) for name, grade in GRADES.items() if grade.by_friction]
FAST = [*(name for name, grade in GRADES.items() if not grade.by_friction), "isotropy"]


@pytest.mark.parametrize("rule", RULES.values(), ids=RULES)
@pytest.mark.parametrize("name", [*FAST, *SLOW])
def test_it_keeps_the_rule(name: str, rule: Rule[Grade]) -> None:
    assert list(rule(GRADES[name])) == []


class Misdeclared(IsotropyGrade):
    quantities: ClassVar = [*IsotropyGrade.quantities]


class OutOfTheTable(IsotropyGrade):
    pass


class WithStop(IsotropyGrade):
    about = "how even it is."


class WithoutColumn(IsotropyGrade):
    column = ""


class Nothing(IsotropyGrade):
    quantities = ()


class ZeroOfNothing(IsotropyGrade):
    def of(self, grasp: Grasp) -> Found:
        return {"index": {"value": 0.0, "reason": grasp.missing}} if grasp.missing else super().of(grasp)


class Single(IsotropyGrade):
    def of(self, grasp: Grasp) -> Found:
        found: dict[str, Any] = dict(super().of(grasp)["index"])
        return {"index": {**found, "value": np.float32(found["value"]) if found["value"] else found["value"]}}


class WithoutReason(IsotropyGrade):
    def of(self, grasp: Grasp) -> Found:
        few = len(grasp.points) < 3 and not grasp.missing
        return {"index": {"value": None, "reason": ""}} if few else super().of(grasp)


class Overwriting(IsotropyGrade):
    def of(self, grasp: Grasp) -> Found:
        found = super().of(grasp)
        grasp.normals[:] = 0.0
        return found


class AboutTheWorld(IsotropyGrade):
    def of(self, grasp: Grasp) -> Found:
        return super().of(replace(grasp, centre_of_mass=np.zeros(3)))


class Slippery(IsotropyGrade):
    def of(self, grasp: Grasp) -> Found:
        found: dict[str, Any] = dict(super().of(grasp)["index"])
        return {"index": {**found, "value": found["value"] and grasp.friction * found["value"]}}


class InMetres(IsotropyGrade):
    def of(self, grasp: Grasp) -> Found:
        return super().of(replace(grasp, torque_scale=1.0))


MUTANTS = [
    ("contract-declared", Misdeclared),
    ("contract-table", OutOfTheTable),
    ("contract-told", WithStop),
    ("contract-keys", WithoutColumn),
    ("contract-something", Nothing),
    ("contract-missing", ZeroOfNothing),
    ("contract-plain", Single),
    ("contract-complete", WithoutReason),
    ("contract-same-again", Overwriting),
    ("contract-anywhere", AboutTheWorld),
    ("contract-units", InMetres),
    ("contract-friction", Slippery),
]


@pytest.mark.parametrize(("code", "mutant"), MUTANTS)
def test_a_rule_is_seen_to_be_broken(code: str, mutant: type[Grade], monkeypatch: pytest.MonkeyPatch) -> None:
    entry = mutant()
    if mutant is not OutOfTheTable:
        monkeypatch.setitem(GRADES, entry.name, entry)
    assert broken(RULES, entry) == {code}


def test_every_rule_is() -> None:
    assert {code for code, _ in MUTANTS} == set(RULES)
