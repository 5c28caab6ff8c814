"""Every controller of the prelude and a stranger's keep each rule, and each rule is seen to be broken."""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from pathlib import Path

import graspdsl_stranger
import numpy as np
import pytest
import yaml
from graspdsl_stranger.potential import Centring

from graspdsl.basis.laws import Bench, Descent, Slope
from graspdsl.basis.potentials import POTENTIALS
from graspdsl.basis.prelude import Definition, prelude
from graspdsl.contracts.controllers import RULES, Written, written
from graspdsl.contracts.rule import Rule
from graspdsl.notation.parser import parse_expression, parse_head
from graspdsl.notation.tree import Head, Name

from .breaking import broken


def controller(head: str, body: str, equation: str = "Nobody 2000", about: str = "what is tried here") -> Definition:
    """A controller as a file has it."""
    return Definition(parse_head(head), parse_expression(body), equation, about, in_prelude=True)


def of_file(path: Path) -> dict[str, Definition]:
    """The controllers of a file, by name."""
    entries = yaml.safe_load(path.read_text("utf-8"))["controllers"].items()
    found = [controller(head, given["is"], given["equation"], given["about"]) for head, given in entries]
    return {definition.head.name.text: definition for definition in found}


STRANGERS = of_file(Path(graspdsl_stranger.__file__).with_name("controllers.yaml"))
ALL = {entry.name: entry for entry in [*written(prelude()), *written(STRANGERS)]}


@pytest.mark.parametrize("rule", RULES.values(), ids=RULES)
@pytest.mark.parametrize("name", ALL)
def test_it_keeps_the_rule(name: str, rule: Rule[Written]) -> None:
    assert list(rule(ALL[name])) == []


def test_the_stranger_has_controllers() -> None:
    assert set(STRANGERS) == {"π_c", "π_gc"}


class Nowhere(Descent):
    def displacement(self, bench: Bench, slope: Slope) -> int:
        return bench.apply("·", "no number", partial(np.multiply, np.nan), super().displacement(bench, slope))


class NotFinite(Centring):
    law = Nowhere(of_moments=True)


SOUND = controller("π_c|Γ_τ Γ_σ", "φ_c|τ_cx(Γ_τ) σ_c(Γ_σ)")
MUTANTS = {
    "contract-notation": replace(SOUND, head=Head(Name("π_alpha"), SOUND.head.effector, SOUND.head.sensor)),
    "contract-told": replace(SOUND, equation=""),
    "contract-parameters": controller("π_c|Γ_τ Γ_σ", "φ_c|τ_cx(Γ_τ) σ_c(Γ_τ)"),
    "contract-formula": controller("π_c|Γ_τ Γ_σ", "φ_c|τ_cx(Γ_τ) σ_cc(Γ_σ)"),
    "contract-use": controller("π_c|Γ Γ (x_ref)", "φ_p|τ_p(Γ) σ_p(Γ) (x_ref) ◁ φ_k|τ_k(Γ) σ_k(Γ)"),
    "contract-moves": controller("π_c|Γ Γ", "φ_fr|τ_frr(Γ) σ_fr(Γ)"),
}


@pytest.mark.parametrize("code", MUTANTS)
def test_a_rule_is_seen_to_be_broken(code: str) -> None:
    [entry] = written({"π_c": MUTANTS[code]})
    assert broken(RULES, entry) == {code}


def test_a_tick_without_a_number_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(POTENTIALS, "φ_c", NotFinite())
    [entry] = written({"π_c": SOUND})
    assert broken(RULES, entry) == {"contract-tick"}


def test_every_rule_is() -> None:
    assert {*MUTANTS, "contract-tick"} == set(RULES)
