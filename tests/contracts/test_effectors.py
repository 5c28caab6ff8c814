"""Every effector transform keeps each rule, and each rule is seen to be broken."""

from __future__ import annotations

from typing import ClassVar

import numpy as np
import pytest
from graspdsl_stranger.effector import NetLeverDisplacement
from graspdsl_stranger.potential import Centring
from graspdsl_stranger.sensor import NetLever

from graspdsl.arrays import Array
from graspdsl.basis.effectors import EFFECTORS, Effector
from graspdsl.basis.sensors import SENSORS, Sensor
from graspdsl.contracts.effectors import RULES
from graspdsl.contracts.rule import Rule

from .breaking import broken


@pytest.mark.parametrize("rule", RULES.values(), ids=RULES)
@pytest.mark.parametrize("symbol", [*EFFECTORS, "τ_cx"])
def test_it_keeps_the_rule(symbol: str, rule: Rule[Effector]) -> None:
    assert list(rule(EFFECTORS[symbol])) == []


class Misdeclared(NetLeverDisplacement):
    __doc__ = NetLeverDisplacement.__doc__
    gradient_space: ClassVar = "x"


class ReadingAText(NetLeverDisplacement):
    __doc__ = NetLeverDisplacement.__doc__
    reads: ClassVar = ["frames"]


class Misspelt(NetLeverDisplacement):
    """τ_alpha, as Roa and Suárez 2015 have it [1]."""

    symbol = "τ_alpha"


class OutOfTheTable(NetLeverDisplacement):
    __doc__ = NetLeverDisplacement.__doc__


class WithoutSymbol(NetLeverDisplacement):
    """The derivative of the net lever (Roa and Suárez 2015) [1]."""


class Reading(NetLeverDisplacement):
    __doc__ = NetLeverDisplacement.__doc__
    reads = ("frame",)


class OfNoPotential(NetLeverDisplacement):
    """τ_cc, as Roa and Suárez 2015 have it [1]."""

    symbol = "τ_cc"


class Transposed(NetLeverDisplacement):
    __doc__ = NetLeverDisplacement.__doc__

    def evaluate(self, mixing: Array, *inputs: Array) -> Array:
        return np.swapaxes(super().evaluate(mixing, *inputs), -1, -2)


class OfOneTrial(NetLeverDisplacement):
    __doc__ = NetLeverDisplacement.__doc__

    def evaluate(self, mixing: Array, *inputs: Array) -> Array:
        (frames,) = inputs
        return super().evaluate(mixing, frames.reshape(-1, *frames.shape[-3:])[0])


class Overwriting(NetLeverDisplacement):
    __doc__ = NetLeverDisplacement.__doc__

    def evaluate(self, mixing: Array, *inputs: Array) -> Array:
        found = super().evaluate(mixing, *inputs)
        inputs[0][...] = 0.0
        return found


class Doubled(NetLeverDisplacement):
    __doc__ = NetLeverDisplacement.__doc__

    def evaluate(self, mixing: Array, *inputs: Array) -> Array:
        return 1.001 * super().evaluate(mixing, *inputs)


class Nothing(NetLeverDisplacement):
    __doc__ = NetLeverDisplacement.__doc__

    def evaluate(self, mixing: Array, *inputs: Array) -> Array:
        return 0.0 * super().evaluate(mixing, *inputs)


class OffTheSurface(NetLeverDisplacement):
    __doc__ = NetLeverDisplacement.__doc__

    def evaluate(self, mixing: Array, *inputs: Array) -> Array:
        found = super().evaluate(mixing, *inputs)
        return np.zeros_like(found) + np.kron(mixing, np.eye(3))


MUTANTS = [
    ("contract-declared", ReadingAText),
    ("contract-symbol", Misspelt),
    ("contract-table", OutOfTheTable),
    ("contract-docstring", WithoutSymbol),
    ("contract-reads", Reading),
    ("contract-potential", OfNoPotential),
    ("contract-shape", Transposed),
    ("contract-batches", OfOneTrial),
    ("contract-pure", Overwriting),
    ("contract-derivative", Doubled),
    ("contract-derivative", Nothing),
    ("contract-derivative", OffTheSurface),
]


@pytest.mark.parametrize(("code", "mutant"), MUTANTS)
def test_a_rule_is_seen_to_be_broken(code: str, mutant: type[Effector], monkeypatch: pytest.MonkeyPatch) -> None:
    entry = mutant()
    if mutant is not OutOfTheTable:
        monkeypatch.setitem(EFFECTORS, entry.symbol, entry)
    if mutant is not OfNoPotential:
        monkeypatch.setattr(Centring, "effectors", (entry.symbol,))
    assert broken(RULES, entry) == {code}


class Weight(NetLever):
    """σ_c: the weight, whatever the contacts are."""

    reads = ("weight",)

    def evaluate(self, mixing: Array, *inputs: Array) -> Array:
        return np.asarray(mixing.sum() * inputs[0])


def test_what_does_not_move_what_is_sensed_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    sensor: Sensor = Weight()
    entry = Nothing()
    monkeypatch.setitem(SENSORS, sensor.symbol, sensor)
    monkeypatch.setitem(EFFECTORS, entry.symbol, entry)
    assert broken(RULES, entry) == {"contract-moves"}


def test_every_rule_is() -> None:
    assert {code for code, _ in MUTANTS} | {"contract-moves"} == set(RULES)
