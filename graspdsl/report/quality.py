"""The grades of a run's grasps, counted: what theory and the simulator say of them, side by side."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import product
from typing import Any

from graspdsl.quality.grade import Found, Grade
from graspdsl.quality.grades import GRADES
from graspdsl.report.statistics import Interval, median, wilson
from graspdsl.trials.outcomes import Outcome
from graspdsl.trials.record import TrialRecord


@dataclass(frozen=True, slots=True)
class Passed:
    """How many grasps passed a grade, of so many, with the Wilson interval of the share."""

    passed: int
    of: int
    share: float
    interval: Interval


@dataclass(frozen=True, slots=True)
class GradeMedian:
    """The median and the range of a quantity of a grade, in its unit, over the grasps that have it."""

    median: float | None
    of: int
    range: Interval | None


@dataclass(frozen=True, slots=True)
class GradeSummary:
    """What a grade says of the final grasps of a run; ``reasons``: why some did not pass or have no measure."""

    grade: Grade
    passed: Passed | None
    medians: Mapping[str, GradeMedian]
    reasons: Mapping[str, int]

    def as_data(self) -> dict[str, Any]:
        """The count of those that passed stands under the grade's own word for that."""
        counted = {}
        if (one := self.passed) is not None:
            counted = {self.grade.passed: one.passed, "of": one.of, "share": one.share, "interval": one.interval}
        return {**counted, **self.medians, "reasons": self.reasons}


@dataclass(frozen=True, slots=True)
class Confusion:
    """Verdicts on grasps side by side: ``table``, all combinations of yes and no with their trials, of so many trials
    that have every verdict; ``outcomes``, how many trials passed each grade, by outcome."""

    of: int
    table: tuple[Mapping[str, bool | int], ...]
    outcomes: Mapping[str, Mapping[str, int]]


@dataclass(frozen=True, slots=True)
class Conventions:
    """By what all grasps of a run were judged: torque scale [m], what it is, edges of a friction pyramid, and how many
    grasps by which contact model."""

    torque_scale: float
    scale: str
    edges: int
    models: Mapping[str, int]


@dataclass(frozen=True, slots=True)
class Quality:
    """The grades that some trial has, by their keys; none, and no confusion, where nothing was graded.

    conventions: None where no grade needs any.
    """

    grades: Mapping[str, GradeSummary]
    confusion: Confusion
    conventions: Conventions | None = None

    def as_data(self) -> dict[str, Any]:
        """Nothing where nothing was graded."""
        conventions = {"conventions": self.conventions} if self.conventions else {}
        return {**self.grades, **conventions, "confusion": self.confusion} if self.grades else {}


def quality(records: Sequence[TrialRecord]) -> Quality:
    """The grades of all trials that began and were graded."""
    begun = [record for record in records if record.outcome is not Outcome.INFEASIBLE_START]
    found = {}
    for name, grade in GRADES.items():
        grades = [record.quality[name] for record in begun if name in record.quality]
        if grades:
            found[grade.key] = _graded(grade, grades)
    return Quality(found, _confusion(begun), _conventions(begun))


def _conventions(records: Sequence[TrialRecord]) -> Conventions | None:
    judged = [found for record in records if (found := next(filter(_has_conventions, record.quality.values()), None))]
    if not judged:
        return None
    models = Counter(found["model"] for found in judged if found["model"])
    return Conventions(judged[0]["length"], judged[0]["scale"], judged[0]["edges"], dict(models.most_common()))


def _has_conventions(found: Found) -> bool:
    return "scale" in found


def _graded(grade: Grade, found: Sequence[Mapping[str, Any]]) -> GradeSummary:
    passed = None
    if grade.passed:
        count = sum(one[grade.passed] for one in found)
        passed = Passed(count, len(found), count / len(found), wilson(count, len(found)))
    medians = {}
    for quantity in grade.quantities:
        known = [one[quantity.key]["value"] for one in found if one[quantity.key]["value"] is not None]
        medians[quantity.key] = GradeMedian(median(known), len(known), (min(known), max(known)) if known else None)
    told = found if grade.passed else [one[grade.quantities[0].key] for one in found]
    reasons = Counter(one["reason"] for one in told if one["reason"])
    return GradeSummary(grade, passed, medians, dict(reasons.most_common()))


def _confusion(records: Sequence[TrialRecord]) -> Confusion:
    """Verdicts: converged, by the residuals, and those that grades give."""
    passing = [grade for grade in GRADES.values() if grade.passed]
    names = ["converged", *dict.fromkeys(grade.verdict for grade in passing if grade.verdict)]
    verdicts: list[dict[str, bool | None]] = []
    outcomes: dict[str, dict[str, int]] = {}
    for record in records:
        passed = {g: bool(record.quality[g.name][g.passed]) for g in passing if g.name in record.quality}
        given = {grade.verdict: yes for grade, yes in passed.items()}
        verdicts.append({"converged": record.outcome is Outcome.CONVERGED, **{n: given.get(n) for n in names[1:]}})
        row = outcomes.setdefault(record.outcome.value, {"trials": 0, **{grade.key: 0 for grade in passing}})
        row["trials"] += 1
        for grade, yes in passed.items():
            row[grade.key] += yes
    judged = [verdict for verdict in verdicts if None not in verdict.values()]
    cells = [dict(zip(names, values, strict=True)) for values in product((True, False), repeat=len(names))]
    return Confusion(
        len(judged),
        tuple({**cell, "trials": sum(verdict == cell for verdict in judged)} for cell in cells),
        dict(sorted(outcomes.items(), key=lambda item: -item[1]["trials"])),
    )
