"""How trials ended: counts with intervals, what was said of each, and one trial to show for it."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from graspdsl.report.statistics import Interval, wilson
from graspdsl.trials.record import TrialRecord

# A number on its own, not part of a name such as finger-3.
_NUMBER = re.compile(r"(?<![\w.-])-?\d+(?:\.\d+)?(?:e[-+]?\d+)?(?![\w.]*\w)")


@dataclass(frozen=True, slots=True)
class Said:
    """What was said of some trials, alike but for its numbers, each as the range that it took; and these trials."""

    detail: str
    trials: tuple[int, ...]


@dataclass(frozen=True, slots=True)
class OutcomeCount:
    """How many trials ended so and what that means, their share with a 95 % Wilson interval, which they are, and what
    was said of them, the most frequent first."""

    outcome: str
    means: str
    count: int
    share: float
    interval: Interval
    trials: tuple[int, ...]
    details: tuple[Said, ...]


def outcome_table(records: Sequence[TrialRecord]) -> list[OutcomeCount]:
    """How trials ended, the most frequent outcome first."""
    counts = Counter(record.outcome for record in records).most_common()
    return [
        OutcomeCount(
            outcome=outcome.value,
            means=outcome.means,
            count=count,
            share=count / len(records),
            interval=wilson(count, len(records)),
            trials=tuple(record.number for record in records if record.outcome is outcome),
            details=grouped((record.number, record.detail) for record in records if record.outcome is outcome),
        )
        for outcome, count in counts
    ]


def representatives(records: Iterable[TrialRecord]) -> dict[str, TrialRecord]:
    """The trial that a report shows of each outcome: the one of least number."""
    shown: dict[str, TrialRecord] = {}
    for record in sorted(records, key=lambda record: record.number):
        shown.setdefault(record.outcome.value, record)
    return shown


def grouped(details: Iterable[tuple[int, str]]) -> tuple[Said, ...]:
    """What was said of trials by number, taken together where it is alike but for its numbers, the most frequent
    first."""
    groups: dict[tuple[str, ...], list[tuple[int, str]]] = {}
    for number, detail in details:
        if detail:
            groups.setdefault(tuple(_NUMBER.split(detail)), []).append((number, detail))
    return tuple(
        Said(_with_ranges(texts, [detail for _, detail in group]), tuple(number for number, _ in group))
        for texts, group in sorted(groups.items(), key=lambda item: -len(item[1]))
    )


def _with_ranges(texts: Sequence[str], details: Sequence[str]) -> str:
    columns = zip(*(_NUMBER.findall(detail) for detail in details), strict=True)
    ranges = []
    for numbers in columns:
        low, high = min(numbers, key=float), max(numbers, key=float)
        ranges.append(low if low == high else f"{low} to {high}")
    first, *others = texts
    return first + "".join(said + text for said, text in zip(ranges, others, strict=True))
