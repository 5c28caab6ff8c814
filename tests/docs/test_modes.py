"""The page on modes: what the script measures, and within the bounds that it tells of."""

from __future__ import annotations

import re
import runpy
from pathlib import Path
from typing import Any

import pytest

DOCS = Path(__file__).resolve().parents[2] / "docs"
PAGE = (DOCS / "modes.md").read_text("utf-8")


@pytest.fixture(scope="module")
def script() -> dict[str, Any]:
    """What the script has."""
    return runpy.run_path(str(DOCS / "render_modes.py"))


def rows(script: dict[str, Any]) -> list[str]:
    """The measured rows of the page: those of its tables below their heads."""
    found = [
        row for table in re.findall(r"^\|(?: --- \|)+\n((?:\|.*\n)+)", PAGE, flags=re.M) for row in table.splitlines()
    ]
    assert len(found) == len(script["ROWS"])
    return found


def percents(row: str) -> list[float]:
    """The rates of a row."""
    return [float(rate) for rate in re.findall(r"([\d.]+) %", row)]


def test_the_page_has_the_scripts_form(script: dict[str, Any]) -> None:
    assert script["page"](rows(script)) == PAGE


@pytest.mark.slow
def test_its_numbers_are_measured_anew(script: dict[str, Any]) -> None:
    law = script["ONE_MODE"][0]
    count = script["COUNTS"][0]
    assert rows(script)[0].startswith(
        f"| {law.name} | {script['percent'](script['parted'](law.draws, count, script['DRAWN']))} |"
    )


def test_its_rates_are_within_their_bounds(script: dict[str, Any]) -> None:
    one = len(script["ONE_MODE"]) + len(script["STRANGERS"])
    two = one + len(script["MIXTURES"])
    measured = rows(script)
    assert max(rate for row in measured[:one] for rate in percents(row)) <= 5.0
    at_58 = next(row for row in measured[one:two] if row.startswith("| 20 % | 58 |"))
    assert min(percents(at_58)[1:4]) >= 80.0  # up to ± 0.10 rad
    for row in measured[two:]:
        ((has, of),) = re.findall(r"(\d+) of (\d+)", row)
        assert int(has) >= 0.9 * int(of)
