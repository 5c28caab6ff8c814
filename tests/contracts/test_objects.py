"""Every object keeps each rule, and each rule is seen to be broken."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from graspdsl.contracts.objects import RULES
from graspdsl.contracts.rule import Rule
from graspdsl.objects.box import Box
from graspdsl.objects.ellipsoid import Ellipsoid
from graspdsl.objects.facets import Hull
from graspdsl.objects.mass import Solid
from graspdsl.objects.shapes import Body, catalogue

from .breaking import broken
from .each import each_rule
from .folders import KITCHEN

CARTON = KITCHEN["juice-carton"]


@each_rule(RULES, "rest", "standing")
@pytest.mark.parametrize("body", [*catalogue().values(), *KITCHEN.values()], ids=lambda body: body.name)
def test_it_keeps_the_rule(body: Body, rule: Rule[Body]) -> None:
    assert list(rule(body)) == []


class Impossible(Box):
    """A box that weighs along one axis alone."""

    @property
    def solid(self) -> Solid:
        return replace(super().solid, moments=np.diag([-1e-8, 1e-8, 1e-8]))


class Pointed(Box):
    """A box that collides as what stands on a point."""

    rests = False

    @property
    def primitive(self) -> None:
        return None

    def hulls(self) -> tuple[Hull, ...]:
        x, y, z = (length / 2 for length in self.size)
        return (Hull(np.array([(x, y, z), (x, -y, z), (-x, y, z), (-x, -y, z), (0.4 * x, 0.0, -z)])),)


MUTANTS = [
    ("named", replace(CARTON, name="juice carton")),
    ("told", replace(CARTON, about="")),
    ("solid", replace(CARTON, shape=Impossible(size=(0.05, 0.06, 0.13)))),
    ("mass", replace(CARTON, mass=1e-4)),
    ("size", replace(CARTON, shape=Box(size=(1.9, 1.9, 0.1)), mass=100.0)),
    ("standing", replace(CARTON, shape=Ellipsoid(size=(0.05, 0.06, 0.13))), "rest"),
    ("rest", replace(CARTON, shape=Pointed(size=(0.05, 0.06, 0.13)))),
]


@pytest.mark.slow
@pytest.mark.parametrize("mutant", MUTANTS, ids=lambda mutant: mutant[0])
def test_a_rule_is_seen_to_be_broken(mutant: tuple[str, Body]) -> None:
    code, body, *others = mutant
    assert broken(RULES, body) == {f"contract-{name}" for name in (code, *others)}


def test_every_rule_is() -> None:
    assert {f"contract-{mutant[0]}" for mutant in MUTANTS} == set(RULES)
