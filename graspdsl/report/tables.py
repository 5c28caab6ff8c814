"""A table: typed values in columns that say how they are written, for a console and a page alike.

The command line renders it in ``graspdsl.cli.tables``, pages with ``table_of`` in their base template. A page has a
column's unit in its head, a console with every value.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from operator import itemgetter
from typing import Any

from graspdsl.report.wording import NOTHING, percent, percents

MOST_NAMED = 12  # trials that are named one by one


@dataclass(frozen=True, slots=True)
class Format:
    """How values are written: their text, their unit, and the number they sort by, None for words.

    What is missing, None or NaN, is a dash. ``words`` are set to the left. ``parts``: the numbers, by name, of values
    that are several, such as the ends of an interval.
    """

    text: Callable[[Any], str]
    key: Callable[[Any], float | None] = lambda value: value
    unit: str = ""
    words: bool = False
    parts: tuple[tuple[str, Callable[[Any], float]], ...] = ()

    def written(self, value: object, *, with_unit: bool = False) -> str:
        """A value as text."""
        if _is_missing(value):
            return NOTHING
        return f"{self.text(value)} {self.unit}".rstrip() if with_unit else self.text(value)

    def sorts_by(self, value: object) -> float | None:
        """The number that a value sorts by, if it does by one."""
        return None if self.words or _is_missing(value) else self.key(value)

    def numbers(self, value: object) -> dict[str, float]:
        """The numbers of a value by the names of its parts, of one number without a name; none of words."""
        number = self.sorts_by(value)
        return {} if number is None else {name: key(value) for name, key in self.parts} or {"": number}


def _is_missing(value: object) -> bool:
    return value is None or (isinstance(value, float) and math.isnan(value))


def scaled(form: str, unit: str = "", scale: float = 1.0) -> Format:
    """Numbers in a format of Python's, in a unit of which the values' own has ``scale``."""
    return Format(lambda value: f"{scale * value:{form}}", lambda value: scale * value, unit)


def fixed(digits: int, unit: str = "", scale: float = 1.0) -> Format:
    """Numbers with so many digits after the point."""
    return scaled(f".{digits}f", unit, scale)


def squared(unit: str = "", scale: float = 1.0) -> Format:
    """Squared errors, which range over orders of magnitude, with two significant digits."""
    return Format(
        lambda value: f"{scale * value:.0f}" if scale * value >= 100.0 else f"{scale * value:.2g}",
        lambda value: scale * value,
        unit,
    )


def trials_named(numbers: Sequence[int]) -> str:
    """Which trials, by number; the first of many."""
    named = ", ".join(map(str, numbers[:MOST_NAMED]))
    return f"{named} and {len(numbers) - MOST_NAMED} more" if len(numbers) > MOST_NAMED else named


def reasons_named(reasons: Mapping[str, int]) -> str:
    """Reasons, each with how often there was it."""
    return "; ".join(f"{reason} ({count})" for reason, count in reasons.items())


WORDS = Format(str, words=True)
COUNT = Format(str)
SHARE = Format(percent)
ENDS = (("low", itemgetter(0)), ("high", itemgetter(1)))
INTERVAL = Format(percents, lambda interval: float(interval[0]), parts=ENDS)
TEXT = Format(str, lambda _: None)  # made of several numbers: to the right as they are, with nothing to sort by
MILLIMETRES = fixed(1, "mm", 1e3)
REASONS = Format(reasons_named, words=True)


@dataclass(frozen=True, slots=True)
class Column:
    """A column: its label and how its values are written; ``left``: set to the left, as words are by themselves."""

    label: str
    format: Format = WORDS
    left: bool = False

    def head(self, *, with_unit: bool) -> str:
        """What stands above it."""
        return f"{self.label} ({self.format.unit})" if with_unit and self.format.unit else self.label


@dataclass(frozen=True, slots=True)
class Value:
    """A value that is not written as the others of its column are."""

    value: object
    format: Format


@dataclass(frozen=True, slots=True)
class Cell:
    """A value written out; ``key``: the number it sorts by, where it does. Words are set to the left."""

    text: str
    key: float | None
    words: bool


@dataclass(frozen=True, slots=True)
class Table:
    """A table: what it shows, its columns, its rows of values, and a note below."""

    title: str
    columns: tuple[Column, ...]
    rows: tuple[tuple[object, ...], ...]
    note: str = ""

    def first(self, count: int) -> Table:
        """Its first columns alone."""
        return replace(self, columns=self.columns[:count], rows=tuple(row[:count] for row in self.rows))

    def cells(self, *, with_units: bool = False) -> list[list[Cell]]:
        """Its rows written out, on a console with the units."""
        return [
            [_cell(value, column.format, with_units) for value, column in zip(row, self.columns, strict=True)]
            for row in self.rows
        ]

    def heads(self) -> list[tuple[str, bool]]:
        """What stands above each column of a page, and whether it is of words."""
        return [(column.head(with_unit=True), column.format.words) for column in self.columns]


def _cell(value: object, form: Format, with_unit: bool) -> Cell:
    if isinstance(value, Value):
        form, value = value.format, value.value
    return Cell(form.written(value, with_unit=with_unit), form.sorts_by(value), form.words)
