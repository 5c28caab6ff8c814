"""The grades of final grasps on a page, whatever a run was graded by."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from graspdsl.quality.lift_and_shake import Handling
from graspdsl.report.page_tables import Cell, PageTable, counted_cell, words
from graspdsl.report.wording import NOTHING, percent, percents

HANDLING = Handling()

# What each grade is, in the terms of the literature.
DEFINITIONS: Mapping[str, str] = {
    "force_closure": "Force closure: the contacts' friction cones can balance any wrench on the object.",
    "ferrari_canny": "Ferrari and Canny's ε: the radius of the largest ball of wrenches about the origin that the "
    "grasp can balance with contact forces of bounded size; volume: that of the set of all wrenches it can balance.",
    "lift": f"Lift: squeezed until the strongest fingertip presses with {HANDLING.squeeze:g} N and raised by "
    f"{100 * HANDLING.height:g} cm, the object moves by less than {1000 * HANDLING.slip:g} mm between the contacts.",
    "shake": f"Shake: the same, shaken by {100 * HANDLING.amplitude:g} cm at {HANDLING.frequency:g} Hz "
    f"({HANDLING.acceleration:.2g} m/s²) along three axes.",
    "confusion": "Grades against one another: how many trials passed or failed both, or one of the two.",
}


def quality_tables(quality: Mapping[str, Any]) -> list[PageTable]:
    """A table for each grade, with its definition below."""
    return [
        _listed(_heading(name), found, DEFINITIONS.get(name, ""))
        if isinstance(found, Sequence) and not isinstance(found, str)
        else PageTable(_heading(name), ("measure", "value"), tuple(_rows(found)), DEFINITIONS.get(name, ""))
        for name, found in quality.items()
    ]


def _listed(title: str, entries: Sequence[Any], note: str) -> PageTable:
    whole = [entry if isinstance(entry, Mapping) else {"value": entry} for entry in entries]
    columns = tuple(dict.fromkeys(name for entry in whole for name in entry))
    rows = tuple(tuple(_cell(name, entry.get(name)) for name in columns) for entry in whole)
    return PageTable(title, tuple(map(_title, columns)), rows, note)


def _rows(found: Any, path: str = "") -> Iterator[tuple[Cell, ...]]:
    """A row for each value, named by the way to it."""
    if isinstance(found, Mapping):
        for name, value in found.items():
            yield from _rows(value, f"{path} {name}".strip())
    else:
        yield words(_title(path)), _cell(path, found)


def _cell(name: str, value: Any) -> Cell:
    last = name.split(" ")[-1]
    if value is None:
        return Cell(NOTHING)
    if last == "interval" and isinstance(value, Sequence) and len(value) == 2:
        return Cell(percents(value), float(value[0]))
    if isinstance(value, bool):
        return words("yes" if value else "no")
    if isinstance(value, int):
        return counted_cell(value)
    if isinstance(value, float):
        return Cell(percent(value) if last == "share" else f"{value:.3g}", value)
    if isinstance(value, Mapping):
        return words(
            "; ".join(f"{_title(str(inner))}: {_cell(str(inner), found).text}" for inner, found in value.items())
        )
    if isinstance(value, Sequence) and not isinstance(value, str):
        return words(", ".join(_cell("", inner).text for inner in value))
    return words(str(value))


def _heading(name: str) -> str:
    title = _title(name)
    return title[:1].upper() + title[1:]


def _title(name: str) -> str:
    return name.replace("_", " ").replace("ferrari canny", "Ferrari–Canny").replace("interval", "95 % interval")
