"""A potential of a stranger, in the table by one line: from its formula to trials, with all that is told of it."""

from __future__ import annotations

import numpy as np
import pytest

from graspdsl.arrays import Array
from graspdsl.basis.laws import Descent
from graspdsl.basis.potentials import POTENTIALS, Residual
from graspdsl.basis.spaces import NET_FORCE
from graspdsl.compiler.explain import explained
from graspdsl.compiler.program import Program, examine, program_of
from graspdsl.contracts.potentials import RULES
from graspdsl.reference.kinds import KINDS
from graspdsl.trials.outcomes import Outcome
from graspdsl.trials.setup import trial_loop

from .specs import floating

EDGE = 0.5
THREE = "{γ1, γ2, γ3}"
FORMULA = f"φ_h|τ_frx({THREE}) σ_fr({THREE})"


class Huber(Residual):
    """φ_h: the squared net unit force, from a length of EDGE on linear in it (Huber 1964, Sec. 3). Dimensionless."""

    symbol = "φ_h"
    about = "force residual that grows no faster than its length"
    equation = "Huber 1964, Sec. 3"
    space = NET_FORCE
    sensors = ("σ_fr",)
    effectors = ("τ_frx",)
    law = Descent(gain="moment_gain")
    lowers = ("force_residual",)

    def value(self, error: Array) -> Array:
        """eᵀe, or what goes on from there along its tangent, shape (...)."""
        length = np.linalg.norm(error, axis=-1)
        return np.where(length < EDGE, length**2, EDGE * (2.0 * length - EDGE))

    def gradient(self, error: Array) -> Array:
        """2e, no longer than 2 EDGE, shape (..., d)."""
        length = np.linalg.norm(error, axis=-1, keepdims=True)
        return np.asarray(2.0 * error / np.maximum(1.0, length / EDGE))


@pytest.fixture(autouse=True)
def in_the_table(monkeypatch: pytest.MonkeyPatch) -> None:
    """One line of the dict."""
    monkeypatch.setitem(POTENTIALS, Huber.symbol, Huber())


def program(until: str = "force_residual: 0.05, hold: 0.2", control: str = "") -> Program:
    """Three floating contacts under the potential, with no complaint at all."""
    examination = examine(floating(FORMULA, until=until, control=control), "test.yaml")
    assert examination.diagnostics == ()
    assert examination.program is not None
    return examination.program


def test_it_keeps_the_contract() -> None:
    """Its gradient is that of its value, among all else."""
    assert [said for rule in RULES.values() for said in rule(POTENTIALS["φ_h"])] == []


def test_it_runs_until_what_it_lowers_is_low() -> None:
    """As far down as φ_fr, by slower steps at first."""
    own, usual = (
        trial_loop(made).run(0, 3).record
        for made in (program(), program_of(floating(FORMULA.replace("φ_h", "φ_fr"), until="force_residual: 0.05"), ""))
    )
    assert own.outcome is usual.outcome is Outcome.CONVERGED
    assert own.force_residual_end < 0.05 < EDGE < own.force_residual_start
    assert own.ticks_to_converge is not None
    assert usual.ticks_to_converge is not None
    assert own.ticks_to_converge > usual.ticks_to_converge


def test_it_is_explained_and_listed() -> None:
    text = explained(program())[0].text()
    assert "φ_h  force residual that grows no faster than its length (Huber 1964, Sec. 3)" in text
    assert "−k∇φ_h" in text
    [entry] = [entry for entry in KINDS["potentials"].rows() if entry["name"] == "φ_h"]
    assert entry["about"] == Huber.about


def test_complaints_know_it() -> None:
    """Its end conditions, its gain, its transforms, and its name where another is misspelt."""

    def said(text: str) -> list[str]:
        return [diagnostic.message for diagnostic in examine(text, "test.yaml").diagnostics]

    assert said(floating(FORMULA, until="moment_residual: 0.005")) == [
        "moment_residual is waited for, but no controller of this phase lowers it"
    ]
    assert said(floating(FORMULA, until="force_residual: 0.05", control="moment_gain: 0")) == [
        "with moment_gain 0, φ_h moves no contact"
    ]
    assert said(floating(f"φ_h|τ_frx({THREE}) σ_mr({THREE})")) == [
        "φ_h works on net unit force (1); σ_mr senses net moment of unit forces (m)"
    ]
    [unknown] = examine(floating(FORMULA.replace("φ_h", "φ_hh")), "test.yaml").diagnostics
    assert unknown.hint == "did you mean φ_h?"
