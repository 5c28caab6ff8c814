"""Whether two runs say the same: each verdict seen to agree, to differ and to be left open."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np
import pytest

from graspdsl.report.agreement import Known, against, agreement_in, same_modes, same_outcome
from graspdsl.report.comparison import pairs_of
from graspdsl.report.evidence import Evidence
from graspdsl.report.judgements import Judgement, Verdict
from graspdsl.report.summary import summarised
from graspdsl.trials.record import TrialRecord

from .hand_made import HandMade, evidence

MANY = 30
AGREES, DIFFERS, UNTOLD = Verdict.AGREES, Verdict.DIFFERS, Verdict.UNTOLD


def run(trials: Sequence[HandMade], change: Callable[[TrialRecord], TrialRecord] = lambda record: record) -> Evidence:
    """A run whose trials began each elsewhere, the same in every run of as many."""
    made = evidence(1, trials)
    records = (change(replace(record, start={"roll": float(record.number)})) for record in made.records)
    return replace(made, records=tuple(records))


def ended(count: int = MANY, **changes: float) -> list[HandMade]:
    """Trials that converged, with small differences from one another."""
    ends = 1.5 + 0.05 * np.random.default_rng(3).random(count)
    return [
        replace(HandMade(end=float(end)), **{k: getattr(HandMade(), k) + v for k, v in changes.items()}) for end in ends
    ]


def turned(trials: Sequence[HandMade], by: float) -> list[HandMade]:
    """The same with other orientations at the end [rad]."""
    return [replace(trial, end=trial.end - by) for trial in trials]


@pytest.mark.slow
def test_a_run_agrees_with_itself() -> None:
    same = run(ended())
    known = same, summarised(same)
    found = against([known, known], 1, 0)
    assert {judgement.verdict for judgement in found.judgements} == {AGREES}
    assert found.outcome.converged == (MANY, 0, 0, 0)
    assert found.quantities["orientation_end"].largest == 0.0


@pytest.mark.parametrize(
    ("quantity", "small", "large", "of"),
    [
        ("force_residual_end", 0.01, 0.05, "force"),
        ("moment_residual_end", 0.0005, 0.003, "moment"),
    ],
)
def test_residuals(quantity: str, small: float, large: float, of: str) -> None:
    for gap, verdict in ((small, AGREES), (large, DIFFERS), (-large, DIFFERS)):
        one = agreement_in(quantity, pairs_of(run(ended()), run(ended(**{of: gap}))))
        assert one.judgement.verdict is verdict
        assert one.shift == pytest.approx(gap)
        assert one.typical == pytest.approx(abs(gap))


def test_orientations() -> None:
    trials = ended()

    def apart(other: Sequence[HandMade], count: int = MANY) -> Judgement:
        return agreement_in("orientation_end", pairs_of(run(trials[:count]), run(other))).judgement

    assert apart(turned(trials, 0.01)).verdict is AGREES
    assert apart(turned(trials, 0.05)).verdict is DIFFERS
    assert apart([*trials[: MANY // 2], *turned(trials[MANY // 2 :], 0.05)]).verdict is UNTOLD
    few = apart(trials[:5], 5)
    assert (few.verdict, few.needed) == (UNTOLD, 6)


def test_one_contact_that_presses_otherwise_is_enough() -> None:
    def pressed(record: TrialRecord) -> TrialRecord:
        return replace(record, contact_forces=(0.5, 0.5, 0.2))

    one = agreement_in("contact_force", pairs_of(run(ended()), run(ended(), pressed)))
    assert (one.judgement.verdict, one.shift) == (DIFFERS, pytest.approx(-0.3))


def test_outcomes() -> None:
    trials = ended()

    def with_stopped(count: int) -> Evidence:
        return run([replace(trial, stopped=place < count) for place, trial in enumerate(trials)])

    for count, verdict in ((0, AGREES), (3, UNTOLD), (15, DIFFERS)):
        outcome = same_outcome(pairs_of(run(trials), with_stopped(count)))
        assert outcome.judgement.verdict is verdict
        assert outcome.same == MANY - count
        assert outcome.apart == ((("converged", "palm-collision", count),) if count else ())
        assert outcome.converged == (MANY - count, count, 0, 0)
    assert outcome.shift is not None
    assert outcome.shift.value == pytest.approx(-0.5)


def test_trials_that_began_elsewhere_are_no_pairs() -> None:
    def elsewhere(record: TrialRecord) -> TrialRecord:
        return replace(record, start={"roll": -1.0})

    found = same_outcome(pairs_of(run(ended()), run(ended(), elsewhere)))
    assert (found.pairs, found.judgement.verdict) == (0, UNTOLD)


@pytest.mark.slow
def test_modes() -> None:
    trials = ended()

    def known(*made: HandMade) -> Known:
        evidence = run(made)
        return evidence, summarised(evidence)

    def parted(low: int, at: float = 0.4) -> Known:
        return known(*turned(trials[:low], 1.5 - at), *trials[low:])

    def verdict(first: Known, other: Known) -> Verdict:
        return same_modes(first, other).judgement.verdict

    one, two = known(*trials), parted(10)
    assert verdict(two, parted(11)) is AGREES
    assert verdict(two, parted(22)) is DIFFERS
    assert verdict(two, parted(10, at=0.7)) is DIFFERS
    assert verdict(one, known(*turned(trials, 0.2))) is DIFFERS
    assert verdict(one, two) is verdict(two, one) is DIFFERS
    few = known(*trials[:5])
    assert verdict(few, few) is UNTOLD
