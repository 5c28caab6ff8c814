"""The grades of a run's grasps, counted: what theory and the simulator say of them, side by side."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from itertools import product
from typing import Any

from graspdsl.report.statistics import median, wilson
from graspdsl.trials.outcomes import Outcome
from graspdsl.trials.record import TrialRecord

Numbers = dict[str, Any]


def quality(records: Sequence[TrialRecord]) -> Numbers:
    """The grades of all trials that began and were graded, as plain data; of grades that no trial has, nothing.

    Shares carry 95 % Wilson intervals; ``reasons`` count why grasps have no closure, no measure or were dropped. The
    confusion table counts trials by three verdicts: converged (the residuals'), force closure, and kept (the
    simulator's: shaken where there was a shake, else lifted), all eight combinations and by outcome.
    """
    records = [record for record in records if record.outcome is not Outcome.INFEASIBLE_START]
    found: Numbers = {}
    if closures := _grades(records, "force-closure"):
        found["force_closure"] = {"closed": sum(g["closed"] for g in closures), **_counted(closures, "closed")}
    if measures := _grades(records, "ferrari-canny"):
        found["ferrari_canny"] = {
            "epsilon": _median(g["epsilon"]["value"] for g in measures),
            "volume": _median(g["volume"]["value"] for g in measures),
            "reasons": _reasons(g["epsilon"] for g in measures),
        }
    for grade in ("lift", "shake"):
        if verdicts := _grades(records, grade):
            found[grade] = {"kept": sum(g["kept"] for g in verdicts), **_counted(verdicts, "kept")}
    if found:
        found["confusion"] = _confusion(records)
    return found


def _grades(records: Iterable[TrialRecord], grade: str) -> list[Mapping[str, Any]]:
    return [record.quality[grade] for record in records if grade in record.quality]


def _counted(grades: Sequence[Mapping[str, Any]], good: str) -> Numbers:
    successes = sum(bool(grade[good]) for grade in grades)
    return {
        "of": len(grades),
        "share": successes / len(grades),
        "interval": wilson(successes, len(grades)),
        "reasons": _reasons(grades),
    }


def _reasons(grades: Iterable[Mapping[str, Any]]) -> dict[str, int]:
    return dict(Counter(grade["reason"] for grade in grades if grade["reason"]).most_common())


def _median(values: Iterable[float | None]) -> Numbers:
    known = [value for value in values if value is not None]
    return {"median": median(known), "of": len(known)}


def _verdicts(record: TrialRecord) -> Numbers:
    """The verdicts that a trial has; None for those that were not asked for."""
    grades = record.quality
    simulated = grades.get("shake", grades.get("lift"))
    return {
        "converged": record.outcome is Outcome.CONVERGED,
        "force_closure": grades["force-closure"]["closed"] if "force-closure" in grades else None,
        "kept": simulated["kept"] if simulated is not None else None,
    }


def _confusion(records: Sequence[TrialRecord]) -> Numbers:
    verdicts = [_verdicts(record) for record in records]
    names = ("converged", "force_closure", "kept")
    judged = [v for v in verdicts if None not in v.values()]
    table = [dict(zip(names, values, strict=True)) for values in product((True, False), repeat=3)]
    by_outcome: dict[str, Numbers] = {}
    for record, verdict in zip(records, verdicts, strict=True):
        row = by_outcome.setdefault(record.outcome.value, {"trials": 0, "force_closure": 0, "lift": 0, "shake": 0})
        row["trials"] += 1
        row["force_closure"] += bool(verdict["force_closure"])
        for grade in ("lift", "shake"):
            row[grade] += bool(record.quality.get(grade, {}).get("kept"))
    return {
        "of": len(judged),
        "table": [{**cell, "trials": judged.count(cell)} for cell in table],
        "outcomes": dict(sorted(by_outcome.items(), key=lambda item: -item[1]["trials"])),
    }
