"""How trials ended: counts with intervals, what was said of each, and one trial to show for it."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterable, Sequence
from typing import Any

from graspdsl.report.statistics import wilson
from graspdsl.trials.record import TrialRecord

# A number on its own, not part of a name such as finger-3.
_NUMBER = re.compile(r"(?<![\w.-])-?\d+(?:\.\d+)?(?:e[-+]?\d+)?(?![\w.]*\w)")


def outcome_table(records: Sequence[TrialRecord]) -> list[dict[str, Any]]:
    """A row for each outcome, the most frequent first: its share with a 95 % Wilson interval, its trials by number and
    by what was said of them."""
    counts = Counter(record.outcome for record in records).most_common()
    return [
        {
            "outcome": outcome.value,
            "means": outcome.means,
            "count": count,
            "share": count / len(records),
            "interval": wilson(count, len(records)),
            "trials": [record.number for record in records if record.outcome is outcome],
            "details": grouped((record.number, record.detail) for record in records if record.outcome is outcome),
        }
        for outcome, count in counts
    ]


def representatives(records: Iterable[TrialRecord]) -> dict[str, TrialRecord]:
    """The trial that a report shows of each outcome: the one of least number."""
    shown: dict[str, TrialRecord] = {}
    for record in sorted(records, key=lambda record: record.number):
        shown.setdefault(record.outcome.value, record)
    return shown


def grouped(details: Iterable[tuple[int, str]]) -> list[dict[str, Any]]:
    """What was said of trials by number, alike but for its numbers, taken together, the most frequent first; each
    number as the range that it took."""
    groups: dict[tuple[str, ...], list[tuple[int, str]]] = {}
    for number, detail in details:
        if detail:
            groups.setdefault(tuple(_NUMBER.split(detail)), []).append((number, detail))
    return [
        {"detail": _with_ranges(texts, [detail for _, detail in group]), "trials": [number for number, _ in group]}
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
