"""How trials ended: counts with intervals, what was said of each, and one trial to show for it."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from graspdsl.report.statistics import wilson
from graspdsl.trials.loop import MOST_REDRAWS, PROBES_STALLED, SECONDS_STALLED
from graspdsl.trials.monitors import Bounds
from graspdsl.trials.outcomes import Outcome
from graspdsl.trials.record import TrialRecord

_BOUNDS = Bounds()
MEANINGS: Mapping[Outcome, str] = {
    Outcome.CONVERGED: f"the end conditions held, and the object had moved by {1000 * _BOUNDS.dragged:g} mm at most",
    Outcome.LOCAL_MINIMUM: f"the residual fell by less than {100 * _BOUNDS.progress:g} % in {SECONDS_STALLED:g} s "
    f"(or {PROBES_STALLED} probes)",
    Outcome.PALM_COLLISION: "the palm touched the object",
    Outcome.CONTACT_LOST: f"a contact was never made, or was lost for {_BOUNDS.lost:g} s",
    Outcome.TOPPLED: f"the object leant by more than {_BOUNDS.lean:g} rad",
    Outcome.JOINT_LIMIT: "time was up with a joint at its limit",
    Outcome.TIMEOUT: "time was up",
    Outcome.DIVERGED: f"the object was moved by more than {1000 * _BOUNDS.shift:g} mm, or dragged by more than "
    f"{1000 * _BOUNDS.dragged:g} mm to a low residual",
    Outcome.CRASHED: f"the simulation failed, or no start in {MOST_REDRAWS} draws was feasible",
}

# A number on its own, not part of a name such as finger-3.
_NUMBER = re.compile(r"(?<![\w.-])-?\d+(?:\.\d+)?(?![\w.]*\w)")


def outcome_table(records: Sequence[TrialRecord]) -> list[dict[str, Any]]:
    """A row for each outcome, the most frequent first: its share with a 95 % Wilson interval, its trials by number and
    by what was said of them."""
    counts = Counter(record.outcome for record in records).most_common()
    return [
        {
            "outcome": outcome.value,
            "means": MEANINGS[outcome],
            "count": count,
            "share": count / len(records),
            "interval": wilson(count, len(records)),
            "trials": [record.number for record in records if record.outcome is outcome],
            "details": _details(record for record in records if record.outcome is outcome),
        }
        for outcome, count in counts
    ]


def representatives(records: Iterable[TrialRecord]) -> dict[str, TrialRecord]:
    """The trial that a report shows of each outcome: the one of least number."""
    shown: dict[str, TrialRecord] = {}
    for record in sorted(records, key=lambda record: record.number):
        shown.setdefault(record.outcome.value, record)
    return shown


def _details(records: Iterable[TrialRecord]) -> list[dict[str, Any]]:
    """What was said, alike but for its numbers, taken together; each number as the range that it took."""
    groups: dict[tuple[str, ...], list[TrialRecord]] = {}
    for record in records:
        if record.detail:
            groups.setdefault(tuple(_NUMBER.split(record.detail)), []).append(record)
    return [
        {"detail": _with_ranges(texts, [record.detail for record in group]), "trials": [r.number for r in group]}
        for texts, group in sorted(groups.items(), key=lambda item: -len(item[1]))
    ]


def _with_ranges(texts: Sequence[str], details: Sequence[str]) -> str:
    columns = zip(*(_NUMBER.findall(detail) for detail in details), strict=True)
    ranges = []
    for numbers in columns:
        low, high = min(numbers, key=float), max(numbers, key=float)
        ranges.append(low if low == high else f"{low} to {high}")
    first, *others = texts
    return first + "".join(said + text for said, text in zip(ranges, others, strict=True))
