"""Tables: typed values, written alike on a console and a page, but for where the unit stands."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any, get_args, get_type_hints

import pytest

from graspdsl.cli.tables import laid_out, text_of
from graspdsl.report.summary import At, Medians, ModeSummary, Stopped, Summary
from graspdsl.report.tables import COUNT, INTERVAL, MILLIMETRES, SHARE, Column, Table, Value, fixed, squared
from graspdsl.report.templating import rendered

TABLE = Table(
    "Moved things",
    (
        Column("thing"),
        Column("trials", COUNT),
        Column("share", SHARE),
        Column("95 %", INTERVAL),
        Column("by", MILLIMETRES),
    ),
    (
        ("<b>", 3, 0.25, (0.1, 0.5), 0.0123),
        ("none", 0, None, (0.0, 1.0), math.nan),
        ("turned", 1, 1.0, (0.2, 1.0), Value(0.5, fixed(2, "rad"))),
    ),
    "a note",
)


def test_a_console_has_the_unit_with_every_value() -> None:
    lines = [" ".join(line.split()) for line in text_of([laid_out(TABLE)]).splitlines()]
    assert lines[:2] == ["Moved things", "thing trials share 95 % by"]
    assert lines[3:] == [
        "<b> 3 25 % 10 % to 50 % 12.3 mm",
        "none 0 – 0 % to 100 % –",
        "turned 1 100 % 20 % to 100 % 0.50 rad",
        "a note",
    ]


def test_a_page_has_it_in_the_head_and_sorts_by_numbers() -> None:
    assert TABLE.heads()[-1] == ("by (mm)", False)
    assert [cell.text for cell in TABLE.cells()[0]] == ["<b>", "3", "25 %", "10 % to 50 %", "12.3"]
    assert [row[-1].key for row in TABLE.cells()] == [pytest.approx(12.3), None, 0.5]
    assert [row[3].key for row in TABLE.cells()] == [0.1, 0.0, 0.2]
    assert [cell.words for cell in TABLE.cells()[0]] == [True, False, False, False, False]


def test_its_first_columns_alone_are_a_table() -> None:
    brief = TABLE.first(2)
    assert [column.label for column in brief.columns] == ["thing", "trials"]
    assert [[cell.text for cell in row] for row in brief.cells()] == [["<b>", "3"], ["none", "0"], ["turned", "1"]]


@pytest.mark.parametrize(
    ("error", "text"), [(0.0123, "12"), (0.00123, "1.2"), (0.1, "100"), (0.2345, "234"), (0.0, "0")]
)
def test_squared_errors_have_two_significant_digits_or_none_after_the_point(error: float, text: str) -> None:
    assert squared("mm²", 1e3).written(error) == text


def parts(kind: Any) -> Iterator[Any]:
    """A type and all that it is made of, notes too."""
    yield kind
    for part in get_args(kind):
        yield from parts(part)


@pytest.mark.parametrize("model", [Summary, Medians, ModeSummary, Stopped])
def test_every_number_of_a_summary_has_a_unit(model: type) -> None:
    for name, kind in get_type_hints(model, include_extras=True).items():
        units = {part for part in parts(kind) if isinstance(part, str) and not isinstance(part, At)}
        assert len(units) == (float in parts(kind)), name


def test_users_text_stays_text_on_a_page() -> None:
    page = rendered("compare.html", runs=[], said=[], tables=[TABLE], methods=[], figures=[])
    assert "&lt;b&gt;" in page
    assert "<b>" not in page
    assert 'data-key="0.25"' in page
