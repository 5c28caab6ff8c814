"""The block of grades in a summary, from records made by hand."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import pytest
from quality.grasps import antipodal, ring

from graspdsl.hands.descriptions import robot
from graspdsl.quality.ferrari_canny import FerrariCannyGrade
from graspdsl.quality.force_closure import ForceClosureGrade
from graspdsl.quality.grade import Grasp
from graspdsl.quality.grasp_matrix import GraspMatrixGrade
from graspdsl.report.quality import quality as quality_of
from graspdsl.report.run_tables import brief_quality_table, judged_by, quality_tables
from graspdsl.report.statistics import wilson
from graspdsl.report.summary import plain
from graspdsl.trials.outcomes import OUTCOMES, Outcome
from graspdsl.trials.record import TrialRecord


def _record(outcome: Outcome, grades: dict[str, dict[str, Any]]) -> TrialRecord:
    unknown = dict.fromkeys(TrialRecord.__annotations__, math.nan)
    return TrialRecord(**{**unknown, "outcome": outcome, "quality": grades})


def _lifted(kept: bool) -> dict[str, Any]:
    reason = "" if kept else "slipped"
    return {"kept": kept, "reason": reason, "borne": {"value": 1.0 if kept else None, "reason": reason}}


def _graded(outcome: Outcome, closed: bool, epsilon: float | None, lifted: bool, shaken: bool) -> TrialRecord:
    why = "" if closed else "wrenches span 5 of 6 dimensions"
    return _record(
        outcome,
        {
            "force-closure": {"closed": closed, "margin": {"value": None, "reason": why}, "reason": why},
            "ferrari-canny": {
                "epsilon": {"value": epsilon, "reason": why},
                "shortfall": {"value": None, "reason": why},
                "volume": {"value": epsilon, "reason": why},
            },
            "lift": _lifted(lifted),
            "shake": _lifted(shaken),
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
    assert found["ferrari_canny"]["epsilon"] == {"median": pytest.approx(0.15), "of": 4, "range": [0.0, 0.4]}
    assert found["ferrari_canny"]["shortfall"] == {"median": None, "of": 0, "range": None}
    assert (found["lift"]["kept"], found["lift"]["of"], found["lift"]["reasons"]) == (4, 5, {"slipped": 1})
    assert found["lift"]["borne"] == {"median": 1.0, "of": 4, "range": [1.0, 1.0]}
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
    found = quality([_record(Outcome.CONVERGED, {"lift": _lifted(True)})])
    assert set(found) == {"lift", "confusion"}
    assert found["confusion"]["of"] == 0


def test_conventions_are_told_once_for_all_grasps() -> None:
    """From records as a trial makes them, of two contacts and of three, and of a trial without any."""
    robot_, grades = robot("barrett", "gantry"), (ForceClosureGrade(), FerrariCannyGrade(), GraspMatrixGrade())
    grasps = [Grasp(robot_, 0.4, 0.041, *contacts) for contacts in (antipodal(), ring(), ring(4))]
    grasps.append(Grasp(robot_, 0.4, 0.041, missing="no contacts"))
    records = [_record(Outcome.CONVERGED, {grade.name: grade.of(grasp) for grade in grades}) for grasp in grasps]
    soft, hard = "soft finger contact, μ = 0.4, μ_t = 0.652 mm", "hard point contact, μ = 0.4"
    assert quality(records)["conventions"] == {
        "torque_scale": 0.041,
        "scale": "the object's radius of gyration",
        "edges": 16,
        "models": {hard: 2, soft: 1},
    }
    told = judged_by(quality_of(records).conventions)
    assert told == (
        "Moments are over a torque scale of 41 mm, the object's radius of gyration, for all grasps. "
        f"Contacts: {hard} (2 grasps); {soft} (1 grasp); 16 edges to a friction cone."
    )
    [table, *others] = quality_tables(quality_of(records))
    assert told in table.note
    assert not any(told in other.note for other in others)
    assert brief_quality_table(quality_of(records)).note.endswith(told.removesuffix("."))
