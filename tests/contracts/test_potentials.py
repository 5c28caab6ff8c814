"""Every potential keeps each rule, and each rule is seen to be broken."""

from __future__ import annotations

from functools import partial
from typing import ClassVar

import numpy as np
import pytest
from graspdsl_stranger.potential import Centring

from graspdsl.arrays import Array
from graspdsl.basis.laws import Bench, Descent, Slope
from graspdsl.basis.potentials import POTENTIALS, Difference, HalfSquared, Potential
from graspdsl.basis.spaces import POSITION
from graspdsl.contracts.potentials import RULES
from graspdsl.contracts.rule import Rule

from .breaking import broken

EACH_RULE = pytest.mark.parametrize("rule", RULES.values(), ids=RULES)


@EACH_RULE
@pytest.mark.parametrize("symbol", [*POTENTIALS, "φ_c"])
def test_it_keeps_the_rule(symbol: str, rule: Rule[Potential]) -> None:
    assert list(rule(POTENTIALS[symbol])) == []


class Misdeclared(Centring):
    __doc__ = Centring.__doc__
    normal_to: ClassVar = ["φ_fr"]


class Misspelt(Centring):
    """φ_alpha by Hartley and Zisserman 2004, A6.8. In m²."""

    symbol = "φ_alpha"


class OutOfTheTable(Centring):
    __doc__ = Centring.__doc__


class WithoutUnit(Centring):
    """φ_c by Hartley and Zisserman 2004, A6.8."""


class NotZero(Centring):
    __doc__ = Centring.__doc__

    def value(self, error: Array) -> Array:
        return super().value(error) + 1.0


class Nothing(Centring):
    __doc__ = Centring.__doc__

    def value(self, error: Array) -> Array:
        return 0.0 * super().value(error)

    def gradient(self, error: Array) -> Array:
        return 0.0 * error


class Steep(Centring):
    __doc__ = Centring.__doc__

    def gradient(self, error: Array) -> Array:
        return 1.001 * super().gradient(error)


class OneAtATime(Centring):
    __doc__ = Centring.__doc__

    def value(self, error: Array) -> Array:
        return super().value(error) * error.ndim


class Overwriting(Centring):
    __doc__ = Centring.__doc__

    def value(self, error: Array) -> Array:
        found = super().value(error)
        error[...] = 0.0
        return found


class Unknown(Centring):
    __doc__ = Centring.__doc__
    sensors = ("σ_c", "σ_cc")


class OfAnotherSpace(Centring):
    __doc__ = Centring.__doc__
    space = POSITION


class LowersNothingKnown(Centring):
    __doc__ = Centring.__doc__
    lowers = ("moment",)


class Silent(Descent):
    without = ""


class WithoutAWord(Centring):
    __doc__ = Centring.__doc__
    law = Silent(gain="moment_gain", of_moments=True)


class NormalToNothing(Centring):
    __doc__ = Centring.__doc__
    normal_to = ("φ_frr",)


class CappedWithoutReference(Centring):
    __doc__ = Centring.__doc__
    is_capped = True


class Astray(Centring):
    __doc__ = Centring.__doc__
    difference = Difference(np.subtract, lambda by, start: start - by, "Δx")


class Unformulable(HalfSquared):
    """φ_c: contacts one by one, by a turn of all (Nobody 2000). In m²."""

    symbol = "φ_c"
    about = "what cannot be"
    equation = "Nobody 2000"
    space = POSITION
    sensors = ("σ_p",)
    effectors = ("τ_frr",)
    law = Descent()


class Nowhere(Descent):
    def displacement(self, bench: Bench, slope: Slope) -> int:
        return bench.apply("·", "no number", partial(np.multiply, np.nan), super().displacement(bench, slope))


class NotFinite(Centring):
    __doc__ = Centring.__doc__
    law = Nowhere(of_moments=True)


class Shared(Descent):
    def displacement(self, bench: Bench, slope: Slope) -> int:
        def slower(step: Array) -> Array:
            return 1e-4 * step / np.linalg.norm(step)

        return bench.apply("·", "by the length of all", slower, super().displacement(bench, slope))


class Together(Centring):
    __doc__ = Centring.__doc__
    law = Shared(of_moments=True)


MUTANTS = [
    ("contract-declared", Misdeclared),
    ("contract-symbol", Misspelt),
    ("contract-table", OutOfTheTable),
    ("contract-docstring", WithoutUnit),
    ("contract-value", NotZero),
    ("contract-value", Nothing),
    ("contract-gradient", Steep),
    ("contract-batches", OneAtATime),
    ("contract-pure", Overwriting),
    ("contract-transforms", Unknown),
    ("contract-transforms", OfAnotherSpace),
    ("contract-conditions", LowersNothingKnown),
    ("contract-gain", WithoutAWord),
    ("contract-normals", NormalToNothing),
    ("contract-references", CappedWithoutReference),
    ("contract-difference", Astray),
    ("contract-formula", Unformulable),
    ("contract-tick", NotFinite),
    ("contract-side-by-side", Together),
]


@pytest.mark.parametrize(("code", "mutant"), MUTANTS)
def test_a_rule_is_seen_to_be_broken(code: str, mutant: type[Potential], monkeypatch: pytest.MonkeyPatch) -> None:
    entry = mutant()
    if mutant is not OutOfTheTable:
        monkeypatch.setitem(POTENTIALS, entry.symbol, entry)
    assert broken(RULES, entry) == {code}


def test_small_errors_may_be_none(monkeypatch: pytest.MonkeyPatch) -> None:
    """A potential that lets errors be that are no larger than it minds keeps all rules."""

    class Lenient(Centring):
        __doc__ = Centring.__doc__

        def value(self, error: Array) -> Array:
            return np.maximum(np.linalg.norm(error, axis=-1) - 0.05, 0.0) ** 2

        def gradient(self, error: Array) -> Array:
            length = np.linalg.norm(error, axis=-1, keepdims=True)
            return 2.0 * error * np.maximum(1.0 - 0.05 / np.maximum(length, 1e-12), 0.0)

    entry = Lenient()
    monkeypatch.setitem(POTENTIALS, entry.symbol, entry)
    assert broken(RULES, entry) == set()


def test_every_rule_is() -> None:
    assert {code for code, _ in MUTANTS} == set(RULES)


def test_what_an_entry_does_not_say_is_told() -> None:
    class Bare(HalfSquared):
        symbol, law, sensors = "φ_b", Descent(), "σ_c"

    said = {found.message: found.hint for found in RULES["contract-declared"](Bare())}
    assert said["Bare: space is not said"] == "say space, TaskSpace"
    assert said["Bare: sensors is tuple[str, ...], found 'σ_c'"] == "write ('σ_c',): a tuple of one has a comma"
    assert len(said) == 5  # about, equation and effectors, too


def test_what_an_entry_raises_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    class Raising(Centring):
        __doc__ = Centring.__doc__

        def value(self, error: Array) -> Array:
            del error
            raise ZeroDivisionError("division by zero")

    entry = Raising()
    monkeypatch.setitem(POTENTIALS, "φ_c", entry)
    [found] = RULES["contract-value"](entry)
    assert found.message == "Raising: raises ZeroDivisionError: division by zero"
    assert found.hint is not None
    assert found.hint.startswith("φ is one number")
