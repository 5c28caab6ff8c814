"""Every monitor keeps each rule, and each rule is seen to be broken."""

from __future__ import annotations

from typing import Any, ClassVar

import numpy as np
import pytest
from graspdsl_stranger.monitor import ReboundMonitor

from graspdsl.arrays import Flags, Rows
from graspdsl.contracts.monitors import RULES
from graspdsl.contracts.rule import Rule
from graspdsl.spec.monitors import MONITORS
from graspdsl.spec.outcomes import DOTS, STROKES, Outcome
from graspdsl.spec.watching import OFF, Lasting, Monitor, SceneFacts, Setting, Sight

from .breaking import broken


@pytest.fixture(autouse=True)
def _stranger(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(MONITORS, ReboundMonitor.key, ReboundMonitor)


@pytest.mark.parametrize("rule", RULES.values(), ids=RULES)
@pytest.mark.parametrize("key", [*MONITORS, "rebound"])
def test_it_keeps_the_rule(key: str, rule: Rule[type[Monitor]]) -> None:
    assert list(rule(MONITORS[key])) == []


class Misdeclared(ReboundMonitor):
    needs: ClassVar = ("gravity",)


class Misspelt(ReboundMonitor):
    key = "Re-bound"


class OutOfTheTable(ReboundMonitor):
    pass


class WithoutUnit(ReboundMonitor):
    description = "the moment residual has risen: rebounded"


class WithoutOutcome(ReboundMonitor):
    description = "the moment residual has risen by more than this (m)"


class FarAway(ReboundMonitor):
    words: ClassVar = {"far": "very far"}


class LooksLikeAnother(ReboundMonitor):
    description = "the moment residual has risen by more than this (m): bounced"
    outcome = Outcome("bounced", "it bounced", "#23292f", DOTS)


class HasAnothers(ReboundMonitor):
    outcome = MONITORS["shift"].outcome
    description = f"the moment residual has risen by more than this (m): {outcome.value}"


class EndsAsTimeout(ReboundMonitor):
    description = "the moment residual has risen by more than this (m): timeout"
    outcome = Outcome.TIMEOUT


class Numbers(ReboundMonitor):
    def speaks(self, sight: Sight) -> Flags:
        return super().speaks(sight).astype(int)


class Hasty(ReboundMonitor):
    def speaks(self, sight: Sight) -> Flags:
        return super().speaks(sight) | (sight.time == 0.0)


class Mute(ReboundMonitor):
    def detail(self, sight: Sight, place: int) -> str:
        del sight, place
        return ""


class Deaf(ReboundMonitor):
    def speaks(self, sight: Sight) -> Flags:
        return np.zeros(len(sight.rows), dtype=bool)


class ByPlace(ReboundMonitor):
    def speaks(self, sight: Sight) -> Flags:
        rows = np.arange(len(sight.rows))
        self._least[rows] = np.minimum(self._least[rows], sight.moment_residual)
        return np.asarray(sight.moment_residual - self._least[rows] > self.bound)


class Remembering(ReboundMonitor):
    def begin_anew(self, rows: Rows) -> None:
        del rows


class ForgettingAll(ReboundMonitor):
    def begin_anew(self, rows: Rows) -> None:
        del rows
        self._least[:] = np.inf


class Overwriting(ReboundMonitor):
    def speaks(self, sight: Sight) -> Flags:
        found = super().speaks(sight)
        sight.moment_residual[:] = 0.0
        return found


class SaysYes(ReboundMonitor):
    @classmethod
    def out_of_reach(cls, bound: Any, scene: SceneFacts) -> Any:
        del bound, scene
        return True


class Stalled(Lasting):
    """A moment residual that neither falls nor rises for a time."""

    key = "stalled_moment"
    description = "the moment residual has kept within 1 mm for longer than this (s): stalled-moment"
    default = 5.0
    outcome = Outcome("stalled-moment", "the moment residual changed no more", "#b4bbc3", STROKES)

    def __init__(self, bound: float, setting: Setting) -> None:
        super().__init__(bound, setting)
        self._at = np.full(len(setting.began), np.nan)

    def happens(self, sight: Sight) -> Flags:
        keeps = np.abs(sight.moment_residual - self._at[sight.rows]) < 1e-3
        self._at[sight.rows] = sight.moment_residual
        return np.asarray(keeps[:, None])

    def detail(self, sight: Sight, place: int) -> str:
        return f"the moment residual kept at {1000.0 * sight.moment_residual[place]:.0f} mm" + self.lasted

    def begin_anew(self, rows: Rows) -> None:
        super().begin_anew(rows)
        self._at[rows] = np.nan


class Patient(Stalled):
    default = 60.0


class Impatient(Stalled):
    default = 0.5


class ForgettingAtOnce(Stalled):
    def happens(self, sight: Sight) -> Flags:
        self.begin_anew(sight.rows)
        return super().happens(sight)


MUTANTS = [
    ("contract-declared", Misdeclared),
    ("contract-key", Misspelt),
    ("contract-table", OutOfTheTable),
    ("contract-description", WithoutUnit),
    ("contract-description", WithoutOutcome),
    ("contract-bound", FarAway),
    ("contract-outcome", LooksLikeAnother),
    ("contract-outcome", HasAnothers),
    ("contract-outcome", EndsAsTimeout),
    ("contract-answer", Numbers),
    ("contract-first-tick", Hasty),
    ("contract-detail", Mute),
    ("contract-detail", Deaf),
    ("contract-beside", ByPlace),
    ("contract-anew", Remembering),
    ("contract-anew", ForgettingAll),
    ("contract-pure", Overwriting),
    ("contract-reach", SaysYes),
]


@pytest.mark.parametrize(("code", "mutant"), MUTANTS)
def test_a_rule_is_seen_to_be_broken(code: str, mutant: type[Monitor], monkeypatch: pytest.MonkeyPatch) -> None:
    if mutant is not OutOfTheTable:
        monkeypatch.delitem(MONITORS, ReboundMonitor.key)
        monkeypatch.setitem(MONITORS, mutant.key, mutant)
    assert broken(RULES, mutant) == {code}


@pytest.mark.parametrize("monitor", [Stalled, Patient, Impatient])
def test_it_may_wait_for_any_time(monitor: type[Monitor], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(MONITORS, monitor.key, monitor)
    assert broken(RULES, monitor) == set()


def test_one_that_waits_in_vain_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(MONITORS, ForgettingAtOnce.key, ForgettingAtOnce)
    assert broken(RULES, ForgettingAtOnce) == {"contract-detail"}


def test_a_default_of_off_is_no_default(monkeypatch: pytest.MonkeyPatch) -> None:
    class Idle(ReboundMonitor):
        default = OFF

    monkeypatch.setitem(MONITORS, Idle.key, Idle)
    assert "contract-bound" in broken(RULES, Idle)


def test_every_rule_is() -> None:
    assert {code for code, _ in MUTANTS} == set(RULES)
