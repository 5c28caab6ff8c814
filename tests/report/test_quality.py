"""The block of grades in a summary, from records made by hand."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import pytest

from graspdsl.report.quality import quality as quality_of
from graspdsl.report.statistics import wilson
from graspdsl.report.summary import plain
from graspdsl.trials.outcomes import OUTCOMES, Outcome
from graspdsl.trials.record import TrialRecord


def _record(outcome: Outcome, grades: dict[str, dict[str, Any]]) -> TrialRecord:
    unknown = dict.fromkeys(TrialRecord.__annotations__, math.nan)
    return TrialRecord(**{**unknown, "outcome": outcome, "quality": grades})


def _graded(outcome: Outcome, closed: bool, epsilon: float | None, lifted: bool, shaken: bool) -> TrialRecord:
    why = "" if closed else "wrenches span 5 of 6 dimensions"
    return _record(
        outcome,
        {
            "force-closure": {"closed": closed, "reason": why},
            "ferrari-canny": {
                "epsilon": {"value": epsilon, "reason": why},
                "volume": {"value": epsilon, "reason": why},
            },
            "lift": {"kept": lifted, "reason": "" if lifted else "slipped"},
            "shake": {"kept": shaken, "reason": "" if shaken else "slipped"},
        },
    )


def quality(records: Sequence[TrialRecord]) -> Any:
    """The block as JSON has it."""
    return plain(quality_of(records))


RECORDS = [
    _graded(Outcome.CONVERGED, True, 0.2, True, True),
    _graded(Outcome.CONVERGED, True, 0.4, True, False),
    _graded(Outcome.CONVERGED, False, 0.0, True, True),
    _graded(OUTCOMES["local-minimum"], True, 0.1, True, False),
    _graded(Outcome.TOPPLED, False, None, False, False),
]


def test_nothing_was_asked_for() -> None:
    assert quality([_record(Outcome.CONVERGED, {})]) == {}
    assert quality([]) == {}


def test_shares_medians_and_reasons() -> None:
    found = quality(RECORDS)
    closure = found["force_closure"]
    assert (closure["closed"], closure["of"], closure["share"]) == (3, 5, 0.6)
    assert closure["interval"] == list(wilson(3, 5))
    assert closure["reasons"] == {"wrenches span 5 of 6 dimensions": 2}
    assert found["ferrari_canny"]["epsilon"] == {"median": pytest.approx(0.15), "of": 4}
    assert (found["lift"]["kept"], found["lift"]["of"], found["lift"]["reasons"]) == (4, 5, {"slipped": 1})
    assert (found["shake"]["kept"], found["shake"]["interval"]) == (2, list(wilson(2, 5)))


def test_three_verdicts_side_by_side() -> None:
    confusion = quality(RECORDS)["confusion"]
    counts = {(cell["converged"], cell["force_closure"], cell["kept"]): cell["trials"] for cell in confusion["table"]}
    assert len(counts) == 8
    assert {verdicts: count for verdicts, count in counts.items() if count} == {
        (True, True, True): 1,
        (True, True, False): 1,
        (True, False, True): 1,
        (False, True, False): 1,
        (False, False, False): 1,
    }
    assert confusion["of"] == 5
    assert confusion["outcomes"]["converged"] == {"trials": 3, "force_closure": 2, "lift": 3, "shake": 2}


def test_trials_that_never_began_are_not_counted() -> None:
    never = _graded(Outcome.INFEASIBLE_START, False, None, False, False)
    assert quality([never, *RECORDS, never]) == quality(RECORDS)
    assert quality([never]) == {}


def test_one_grade_alone() -> None:
    found = quality([_record(Outcome.CONVERGED, {"lift": {"kept": True, "reason": ""}})])
    assert set(found) == {"lift", "confusion"}
    assert found["confusion"]["of"] == 0
