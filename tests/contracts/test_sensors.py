"""Every sensor transform keeps each rule, and each rule is seen to be broken."""

from __future__ import annotations

import re
from pathlib import Path
from typing import ClassVar

import numpy as np
import pytest
from graspdsl_stranger.sensor import NetLever

from graspdsl.arrays import Array
from graspdsl.basis.sensors import SENSORS, Sensor
from graspdsl.basis.spaces import NORMAL
from graspdsl.compiler.general_position import in_general_position
from graspdsl.compiler.program import program_of_expression
from graspdsl.contracts.drawing import JOINTS, READABLE, generator, inputs
from graspdsl.contracts.rule import Rule
from graspdsl.contracts.scene import CONTACTS
from graspdsl.contracts.sensors import RULES

from .breaking import broken


@pytest.mark.parametrize("rule", RULES.values(), ids=RULES)
@pytest.mark.parametrize("symbol", [*SENSORS, "σ_c"])
def test_it_keeps_the_rule(symbol: str, rule: Rule[Sensor]) -> None:
    assert list(rule(SENSORS[symbol])) == []


class Misdeclared(NetLever):
    __doc__ = NetLever.__doc__
    reads: ClassVar = ["points", "centre_of_mass"]


class Misspelt(NetLever):
    """σ_alpha, as Roa and Suárez 2015 have it [m]."""

    symbol = "σ_alpha"


class OutOfTheTable(NetLever):
    __doc__ = NetLever.__doc__


class WithoutSource(NetLever):
    """σ_c: the net lever of the contacts [m]."""


class Reading(NetLever):
    __doc__ = NetLever.__doc__
    reads = ("points", "mass")


class Measuring(NetLever):
    __doc__ = NetLever.__doc__
    measures = "lever"


class Sized(NetLever):
    __doc__ = NetLever.__doc__

    def evaluate(self, mixing: Array, *inputs: Array) -> Array:
        return (mixing[:, None] * inputs[0])[..., mixing > 0.0, 0]


class OfOneTrial(NetLever):
    __doc__ = NetLever.__doc__

    def evaluate(self, mixing: Array, *inputs: Array) -> Array:
        points, centre = inputs
        return np.asarray(mixing @ (points - centre.reshape(-1, 3)[0]))


class Overwriting(NetLever):
    __doc__ = NetLever.__doc__

    def evaluate(self, mixing: Array, *inputs: Array) -> Array:
        points, centre = inputs
        points -= centre[..., None, :]
        return np.asarray(mixing @ points)


class Remembering(NetLever):
    __doc__ = NetLever.__doc__
    odd = True

    def evaluate(self, mixing: Array, *inputs: Array) -> Array:
        self.odd = not self.odd
        return super().evaluate(mixing, *inputs) * (1.0 + 1e-14 * self.odd)


class UnitAfterwards(Sensor):
    """σ_u: unit vectors along the mean normals (Nobody 2000) [1]."""

    symbol = "σ_u"
    about = "unit mean normals"
    equation = "Nobody 2000"
    space = NORMAL
    reads = ("normals",)
    per_contact = True

    def evaluate(self, mixing: Array, *inputs: Array) -> Array:
        (normals,) = inputs
        found = mixing @ normals
        return np.asarray(found / np.linalg.norm(found, axis=-1, keepdims=True))


class OfAll(NetLever):
    __doc__ = NetLever.__doc__

    def evaluate(self, mixing: Array, *inputs: Array) -> Array:
        points, _ = inputs
        return np.asarray(mixing @ (points - points.mean(axis=-2, keepdims=True)))


MUTANTS = [
    ("contract-declared", Misdeclared),
    ("contract-symbol", Misspelt),
    ("contract-table", OutOfTheTable),
    ("contract-docstring", WithoutSource),
    ("contract-reads", Reading),
    ("contract-roles", Measuring),
    ("contract-shape", Sized),
    ("contract-batches", OfOneTrial),
    ("contract-pure", Overwriting),
    ("contract-pure", Remembering),
    ("contract-means", UnitAfterwards),
    ("contract-own-contacts", OfAll),
]


@pytest.mark.parametrize(("code", "mutant"), MUTANTS)
def test_a_rule_is_seen_to_be_broken(code: str, mutant: type[Sensor], monkeypatch: pytest.MonkeyPatch) -> None:
    entry = mutant()
    if mutant is not OutOfTheTable:
        monkeypatch.setitem(SENSORS, entry.symbol, entry)
    assert broken(RULES, entry) == {code}


@pytest.mark.parametrize("name", READABLE)
def test_what_a_sensor_may_read_is_there_and_told(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    class Reader(NetLever):
        reads = (name,)

        def evaluate(self, mixing: Array, *inputs: Array) -> Array:
            del mixing
            found.append(inputs[0])
            return np.zeros(3)

    found: list[Array] = []
    monkeypatch.setitem(SENSORS, Reader.symbol, Reader())
    program = program_of_expression(f"φ_c|τ_cx({CONTACTS}) σ_c({CONTACTS})")
    for (pipeline,) in program.pipelines():
        pipeline.evaluate(in_general_position(program.robot))
    k, n = len(program.robot.contacts), len(program.robot.joints)
    given = inputs(generator(), k)[name]
    [seen] = found
    assert seen.shape == tuple(n if size == JOINTS else size for size in given.shape)
    page = Path(__file__).parents[2] / "docs" / "contracts" / "sensor.md"
    assert re.search(rf"^\|.*`{name}`.*\|$", page.read_text("utf-8"), flags=re.M)


def test_every_rule_is() -> None:
    assert {code for code, _ in MUTANTS} == set(RULES)
