"""Verdicts by intervals, and how many trials would tell."""

from __future__ import annotations

import math

import pytest
from scipy import stats

from graspdsl.report.judgements import Judgement, Verdict, every, judged_share, judged_value

AGREES, DIFFERS, UNTOLD = Verdict.AGREES, Verdict.DIFFERS, Verdict.UNTOLD


@pytest.mark.parametrize("bound", [0.01, 0.1, 0.5, 0.8])
@pytest.mark.parametrize("count", [1, 3, 10, 58])
def test_a_share_is_seldom_judged_wrongly(bound: float, count: int) -> None:
    """Of trials whose share is just the bound, hardly more than one run in forty agrees, and as few differ."""
    chances = dict.fromkeys(Verdict, 0.0)
    for part in range(count + 1):
        chances[judged_share(part, count, bound).verdict] += float(stats.binom.pmf(part, count, bound))
    assert chances[AGREES] <= 0.025 + 1e-9
    assert chances[DIFFERS] <= 0.025 + 1e-9


@pytest.mark.parametrize(("part", "count"), [(9, 11), (47, 58), (3, 4), (26, 28), (1, 2)])
def test_so_many_trials_would_tell_and_no_fewer(part: int, count: int) -> None:
    needed = judged_share(part, count, 0.8).needed
    assert needed is not None
    times = math.ceil(needed / count)
    assert judged_share(times * part, times * count, 0.8).verdict is not UNTOLD
    assert judged_share((needed // count - 1) * part, (needed // count - 1) * count, 0.8).verdict is UNTOLD


def test_what_no_number_of_trials_tells() -> None:
    assert judged_share(8, 10, 0.8) == Judgement(UNTOLD, 10, None)
    assert judged_value(1.0, (0.0, 2.0), 9, 1.0, math.inf).needed is None
    assert judged_value(-math.inf, (-math.inf, 3.0), 9, 1.0, math.inf) == Judgement(UNTOLD, 9, None)


def test_of_no_trials_at_all_all_would_have_to_agree() -> None:
    needed = judged_share(0, 0, 0.8).needed
    assert needed is not None
    assert judged_share(needed, needed, 0.8).verdict is AGREES
    assert judged_share(needed - 1, needed - 1, 0.8).verdict is UNTOLD


def test_the_largest_run_decides_among_what_cannot_be_told() -> None:
    """25 of six trials take four times as large a run, 131 of 58 little more than twice."""
    rare, common = Judgement(UNTOLD, 6, 25), Judgement(UNTOLD, 58, 131)
    assert every(common, rare) is rare
    assert every(Judgement(AGREES, 9), common).verdict is UNTOLD
    assert every(Judgement(AGREES, 9), common, Judgement(DIFFERS, 9)).verdict is DIFFERS
