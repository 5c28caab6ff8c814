"""The grades of final grasps on a page: each grade, wrench-space measures, and the verdicts side by side."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from graspdsl.quality.lift_and_shake import Handling
from graspdsl.report.page_tables import Cell, PageTable, counted_cell, words
from graspdsl.report.wording import NOTHING, percent, percents

Numbers = Mapping[str, Any]
TEST = Handling()
GRADES = {"force_closure": ("force closure", "closed"), "lift": ("lift", "kept"), "shake": ("shake", "kept")}

# What each grade is, in the terms of the literature.
DEFINITIONS: Mapping[str, str] = {
    "force_closure": "Force closure: the contacts' friction cones can balance any wrench on the object.",
    "ferrari_canny": "Ferrari and Canny's ε: the radius of the largest ball of wrenches about the origin that the "
    "grasp can balance with contact forces of bounded size; volume: that of the set of all wrenches it can balance.",
    "lift": f"Lift: squeezed until the strongest fingertip presses with {TEST.squeeze:g} N and raised by "
    f"{100 * TEST.height:g} cm, the object moves by less than {1000 * TEST.slip:g} mm between the contacts.",
    "shake": f"Shake: the same, shaken by {100 * TEST.amplitude:g} cm at {TEST.frequency:g} Hz "
    f"(up to {TEST.acceleration:.1f} m/s²) along three axes.",
}


def quality_tables(quality: Numbers) -> list[PageTable]:
    """The tables of what ``quality`` found; of grades that no trial has, nothing."""
    if not quality:
        return []
    grades = [name for name in GRADES if name in quality]
    tables = [_verdicts(quality, grades)] if grades else []
    if "ferrari_canny" in quality:
        tables.append(_measures(quality["ferrari_canny"]))
    confusion = quality["confusion"]
    if confusion["of"]:
        tables.append(_side_by_side(confusion))
    if grades:
        tables.append(_by_outcome(confusion["outcomes"], grades))
    return tables


def _verdicts(quality: Numbers, grades: list[str]) -> PageTable:
    rows = []
    for name in grades:
        found, (title, passed) = quality[name], GRADES[name]
        rows.append(
            (
                words(title),
                counted_cell(found[passed]),
                counted_cell(found["of"]),
                Cell(percent(found["share"]), found["share"]),
                Cell(percents(found["interval"]), found["interval"][0]),
                words(_reasons(found["reasons"])),
            )
        )
    columns = ("grade", "passed", "of", "share", "95 % interval", "why not")
    note = " ".join([*(DEFINITIONS[name] for name in grades), "Trials that could not begin are not counted."])
    return PageTable("Verdicts", columns, tuple(rows), note)


def _measures(found: Numbers) -> PageTable:
    rows = tuple(
        (words(title), _number(found[name]["median"]), counted_cell(found[name]["of"]))
        for name, title in (("epsilon", "ε"), ("volume", "volume"))
    )
    missing = f" Without a measure: {_reasons(found['reasons'])}." if found["reasons"] else ""
    return PageTable("Ferrari–Canny", ("measure", "median", "trials"), rows, DEFINITIONS["ferrari_canny"] + missing)


def _side_by_side(confusion: Numbers) -> PageTable:
    names = ("converged", "force_closure", "kept")
    rows = tuple(
        (*(words("yes" if cell[name] else "no") for name in names), counted_cell(cell["trials"]))
        for cell in confusion["table"]
        if cell["trials"]
    )
    note = "Converged: by the residuals. Kept: by the simulator, shaken where there was a shake, else lifted."
    return PageTable("Verdicts side by side", ("converged", "force closure", "kept", "trials"), rows, note)


def _by_outcome(outcomes: Numbers, grades: list[str]) -> PageTable:
    rows = tuple(
        (words(outcome), counted_cell(row["trials"]), *(counted_cell(row[name]) for name in grades))
        for outcome, row in outcomes.items()
    )
    columns = ("outcome", "trials", *(f"{GRADES[name][0]} passed" for name in grades))
    return PageTable("Verdicts by outcome", columns, rows)


def _number(value: float | None) -> Cell:
    return Cell(NOTHING) if value is None else Cell(f"{value:.3g}", value)


def _reasons(reasons: Mapping[str, int]) -> str:
    return "; ".join(f"{reason} ({count})" for reason, count in reasons.items())
