"""What a report shows, as columns of plain values with their units, by name."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from functools import partial
from itertools import product
from typing import Any, get_args, get_type_hints

import numpy as np

from graspdsl.arrays import Array, Float32Array
from graspdsl.compiler.program import Program
from graspdsl.hands.descriptions import joint_units
from graspdsl.report.claims import Claim
from graspdsl.report.data_files import Columns
from graspdsl.report.evidence import Evidence
from graspdsl.report.figure_data import FigureData, figure_tables
from graspdsl.report.run_tables import page_tables, quality_tables, starts_tables
from graspdsl.report.summary import At, Converged, Count, Medians, Stopped, Summary
from graspdsl.report.tables import Format, Table, Value
from graspdsl.report.wording import NOTHING
from graspdsl.trials.columns import Column
from graspdsl.trials.priorities import CAUSES
from graspdsl.trials.trajectories import CHANNELS, CONTACTS, JOINTS
from graspdsl.worlds.protocol import PARTIES

TRIALS, TRAJECTORY = "trials", "trajectory"  # a row a trial; a row a tick of one trial
ALL = "all"  # tables

_RESIDUALS = {"force": "1", "force_squared": "1", "moment": "m", "moment_squared": "m²"}
_COUNTED = {get_args(Count)[1]: "1"}
_XYZ = ("x", "y", "z")
_LOAD = ("fx", "fy", "fz", "mx", "my", "mz")


def tables_of(
    evidence: Evidence, summary: Summary, figures: Iterable[FigureData], claims: Sequence[Claim] = ()
) -> dict[str, Callable[[], Columns]]:
    """What a report shows besides single trials, by name: ``summary``, its numbers one by one; the tables of its page
    that have a row; ``courses``, the residuals that its curves are made from; ``figure-…``, what its figures draw."""
    rejected, kept = [*starts_tables(summary), *[Table("", (), ())] * 2][:2]
    tables = {
        **page_tables(summary, claims),
        "rejected-starts": rejected,
        "kept-starts": kept,
        **{f"quality-{_slug(table.title)}": table for table in quality_tables(summary.quality)},
    }
    made: dict[str, Callable[[], Columns]] = {"summary": partial(_summary, summary)}
    made |= {name: partial(columns_of_table, table) for name, table in tables.items() if table.rows}
    if any(len(course.time) for course in evidence.courses.values()):
        made["courses"] = partial(_courses, evidence)
    return made | figure_tables(figures)


def columns_of_table(table: Table) -> dict[str, Column]:
    """A table as columns: numbers as they are, in the unit that a page has them in, shares from 0 to 1; what has
    several parts as a column each, of intervals ``.low`` and ``.high``; as text what is no number in every row. Where
    the numbers of a column are in several units, a column ``unit`` has that of each row."""
    found: dict[str, Column] = {}
    units_of_rows: dict[int, str] = {}
    for place, column in enumerate(table.columns):
        cells = [_cell(row[place], column.format) for row in table.rows]
        numbers = [form.numbers(value) for form, value in cells]
        units = {row: form.unit or "1" for row, (form, _) in enumerate(cells) if numbers[row]}
        worded = any(form.written(value) != NOTHING for row, (form, value) in enumerate(cells) if not numbers[row])
        if worded or (column.format.words and not units):
            texts = ["" if value is None else form.written(value) for form, value in cells]
            found[column.label] = Column(np.array(texts, dtype=np.str_), "")
            continue
        unit, *others = {*units.values()} or {column.format.unit or "1"}
        if others:
            units_of_rows |= units
        for name in dict.fromkeys(name for row in numbers for name in row) or ("",):
            label = f"{column.label}.{name}" if name else column.label
            found[label] = _numbers([row.get(name) for row in numbers], "" if others else unit)
    if units_of_rows:
        texts = [units_of_rows.get(row, "") for row in range(len(table.rows))]
        found["unit"] = Column(np.array(texts, dtype=np.str_), "")
    return found


def columns_of_trajectory(program: Program, rows: Mapping[str, Float32Array]) -> dict[str, Column]:
    """The trajectory of a trial of a program, a row a tick, a column for each number: ``points.finger-1.x``."""
    found: dict[str, Column] = {}
    slides = joint_units(program.robot) if program.world.has("hand") else {}
    for name, values in rows.items():
        channel = CHANNELS[name]
        axes = [_places(program, name, axis, size) for axis, size in zip(channel.axes, values.shape[1:], strict=True)]
        flat = values.reshape(len(values), math.prod(values.shape[1:]))
        for place, parts in enumerate(product(*axes)):
            unit = slides.get(parts[0], channel.unit) if channel.axes == (JOINTS,) else channel.unit
            if name == "loads":
                unit = "N" if parts[1].startswith("f") else "N·m"
            found[".".join((name, *parts))] = Column(flat[:, place], unit)
    return found


def _places(program: Program, name: str, axis: int | str, size: int) -> Sequence[str]:
    """What the places along an axis of a trajectory's array are called."""
    names: Sequence[str] = _XYZ if axis == len(_XYZ) else tuple(map(str, range(size)))
    if axis == CONTACTS:
        names = tuple(program.robot.contacts)
    elif axis == JOINTS:
        names = tuple(program.robot.joints)
    elif name == "loads":
        names = _LOAD if size == len(_LOAD) else PARTIES
    elif name == "disturbance_by_cause" and size == len(CAUSES):
        names = CAUSES
    return names[:size]  # none of joints where contacts float


def _cell(value: object, form: Format) -> tuple[Format, Any]:
    return (value.format, value.value) if isinstance(value, Value) else (form, value)


def _numbers(values: Sequence[float | None], unit: str) -> Column:
    if values and all(isinstance(value, int) for value in values):
        return Column(np.array(values, dtype=np.int64), unit)
    return Column(np.array([math.nan if value is None else value for value in values], dtype=float), unit)


def _summary(summary: Summary) -> dict[str, Column]:
    """The numbers of a summary one by one, each where it stands in JSON, with its unit."""
    balance, conventions = summary.balance, summary.quality.conventions
    found = [*_told(summary, "", "1"), *_told(summary.starts, "starts.", "1"), *_told(balance, "balance.", "1")]
    if balance.acceleration and balance.alone:
        found += _told(balance.acceleration, "balance.acceleration.", "m/s²")
        found += _told(balance.alone.aside, "balance.without_table.aside.", "m/s²")
        found += _told(balance.alone.falling, "balance.without_table.falling.", "m/s²")
    if conventions:
        found += [("quality.conventions.torque_scale", conventions.torque_scale, "m")]
        found += [("quality.conventions.edges", conventions.edges, "1")]
    names, values, units = zip(*found, strict=True)
    return {
        "name": Column(np.array(names, dtype=np.str_), ""),
        "value": Column(np.array(values, dtype=float), ""),
        "unit": Column(np.array(units, dtype=np.str_), ""),
    }


def _told(part: Any, within: str, unit: str) -> Iterator[tuple[str, float, str]]:
    for name, kind in get_type_hints(type(part), include_extras=True).items():
        notes, value = get_args(kind)[1:] if hasattr(kind, "__metadata__") else (), getattr(part, name)
        place = within + next((str(note) for note in notes if isinstance(note, At)), name)
        said = next((note for note in notes if isinstance(note, str) and not isinstance(note, At)), "1")
        own = unit if said.startswith(("the residual", "its unit")) else _COUNTED.get(said, said)
        if isinstance(value, Medians | Converged | Stopped):
            yield from _told(value, f"{place}.", _RESIDUALS.get(name, "1"))
        elif name == "outcomes":
            yield from ((f"{place}.{outcome}", count, "1") for outcome, count in value.items())
        elif name == "interval":
            yield from ((f"{place}.{end}", number, own) for end, number in zip(("low", "high"), value, strict=True))
        elif name != "seed" and (isinstance(value, int | float) or (value is None and notes)):
            yield place, math.nan if value is None else value, own


def _courses(evidence: Evidence) -> dict[str, Column]:
    """The residuals of each trial from where its controller took over, a row a tick or probe."""
    courses = evidence.courses
    numbers = [np.full(len(course.time), number, dtype=np.int64) for number, course in courses.items()]
    parts: tuple[tuple[str, str, list[Array]], ...] = (
        ("time", "s", [course.time for course in courses.values()]),
        ("force_residual", "1", [course.force for course in courses.values()]),
        ("moment_residual", "m", [course.moment for course in courses.values()]),
    )
    found = {name: Column(np.concatenate(each), unit) for name, unit, each in parts}
    return {"number": Column(np.concatenate(numbers), "1"), **found}


def _slug(title: str) -> str:
    return re.sub(r"\W+", "-", title.lower()).strip("-")
