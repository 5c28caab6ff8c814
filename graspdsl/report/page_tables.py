"""The tables of a run's page: texts with what they sort by."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from graspdsl.report.claim_words import MARKS
from graspdsl.report.judgements import Verdict
from graspdsl.report.wording import NOTHING, percent, percents, quantiles

Numbers = Mapping[str, Any]
MOST_ROWS = 5000  # trials that a page lists
MOST_NAMED = 12  # trials that are named one by one


@dataclass(frozen=True, slots=True)
class Cell:
    """A text of a table; ``key``: the number it sorts by, where it is one. Words are set to the left."""

    text: str
    key: float | None = None
    words: bool = False


@dataclass(frozen=True, slots=True)
class PageTable:
    """A table of a page: what it shows, its columns, its rows, and a note below."""

    title: str
    columns: tuple[str, ...]
    rows: tuple[tuple[Cell, ...], ...]
    note: str = ""


def words(text: str) -> Cell:
    """A cell of words, sorted by them."""
    return Cell(text, words=True)


def counted_cell(count: int) -> Cell:
    """A cell with a count."""
    return Cell(str(count), count)


def trials_named(numbers: Sequence[int]) -> str:
    """Which trials, by number; the first of many."""
    named = ", ".join(map(str, numbers[:MOST_NAMED]))
    return f"{named} and {len(numbers) - MOST_NAMED} more" if len(numbers) > MOST_NAMED else named


def modes_table(numbers: Numbers) -> PageTable:
    """The modes of the end orientation, each with the medians of its trials."""
    rows = [
        (
            Cell(f"mode {rank}", rank),
            _value(mode["centre"], "{:.2f}"),
            counted_cell(len(mode["trials"])),
            Cell(percent(mode["share"]), mode["share"]),
            Cell(percents(mode["interval"]), mode["interval"][0]),
            _value(mode["force_residual"], "{:.3f}"),
            _squared(mode["force_squared"]),
            _value(mode["moment_residual"], "{:.1f}", 1e3),
            _squared(mode["moment_squared"], 1e6),
        )
        for rank, mode in enumerate(numbers["modes"], 1)
    ]
    columns = (
        "mode",
        "peak (rad)",
        "trials",
        "share",
        "95 % interval",
        "‖ρ_f‖",
        "ε_f = ‖ρ_f‖²",
        "‖ρ_m‖ (mm)",
        "ε_m = ‖ρ_m‖² (mm²)",
    )
    return PageTable("Modes of the end orientation", columns, tuple(rows), "Residuals: medians over a mode's trials.")


def residuals_table(numbers: Numbers) -> PageTable:
    """Residuals and squared errors before and after, medians over trials."""
    force, moment = numbers["residuals"]["force"], numbers["residuals"]["moment"]
    rows = []
    for label, found, form, scale in (
        ("force residual ‖ρ_f‖", force, "{:.3f}", 1.0),
        ("ε_f = ‖ρ_f‖²", force["squared"], "", 1.0),
        ("moment residual ‖ρ_m‖ (mm)", moment, "{:.1f}", 1e3),
        ("ε_m = ‖ρ_m‖² (mm²)", moment["squared"], "", 1e6),
    ):
        medians = [found[when] for when in ("start", "end", "end_in_contact")]
        ends = [_value(median, form, scale) if form else _squared(median, scale) for median in medians]
        rows.append((words(label), *ends))
    columns = ("median over trials", "start", "end", "end, all contacts touching")
    return PageTable("Residuals at start and end", columns, tuple(rows))


def outcomes_table(numbers: Numbers) -> PageTable:
    """How trials ended, what that means, and what was said of them."""
    rows = [
        (
            words(entry["outcome"]),
            counted_cell(entry["count"]),
            Cell(percent(entry["share"]), entry["share"]),
            Cell(percents(entry["interval"]), entry["interval"][0]),
            words(entry["means"]),
            words("; ".join(f"{said['detail']} (trial {trials_named(said['trials'])})" for said in entry["details"])),
        )
        for entry in numbers["outcome_table"]
    ]
    columns = ("outcome", "trials", "share", "95 % interval", "meaning", "details")
    return PageTable("How trials ended", columns, tuple(rows))


def starts_tables(numbers: Numbers) -> list[PageTable]:
    """Why draws of a start could not be taken up, and what that made of the starts; nothing where all could be."""
    starts = numbers["starts"]
    if not starts["rejected"]:
        return []
    reasons = [
        (words(reason), counted_cell(count), Cell(percent(count / starts["draws"]), count))
        for reason, count in starts["rejected"].items()
    ]
    kept = [
        (words(name), words(quantiles(found["asked"], found["unit"])), words(quantiles(found["kept"], found["unit"])))
        for name, found in starts["parameters"].items()
    ]
    columns = ("number of a start", "asked for", "kept")
    note = "Quantiles: 5 %, 50 % and 95 %."
    tables = [
        PageTable("Draws that could not be taken up", ("reason", "draws", "share of all draws"), tuple(reasons)),
        PageTable("Starts, asked for and kept", columns, tuple(kept), note),
    ]
    return [table for table in tables if table.rows]


def sensing_table(numbers: Numbers) -> PageTable:
    """The errors of sensed contact points and normals."""
    found = numbers["sensing"]
    rows = (
        (
            words("contact point (mm)"),
            _value(found["point_error_p50"], "{:.2f}", 1e3),
            _value(found["point_error_p95"], "{:.2f}", 1e3),
        ),
        (
            words("contact normal (°)"),
            _value(found["normal_error_p50"], "{:.2f}", math.degrees(1.0)),
            _value(found["normal_error_p95"], "{:.2f}", math.degrees(1.0)),
        ),
    )
    return PageTable("Sensing error", ("error of the sensed", "50th percentile", "95th percentile"), rows)


def claims_table(claims: Sequence[Numbers]) -> PageTable:
    """What the chapter says of this experiment, and what was measured."""
    rows = tuple(
        (
            words(str(claim["says"])),
            words(str(claim["bound"])),
            words(str(claim["measured"])),
            words(MARKS[Verdict(claim["verdict"])]),
            words(str(claim["why"])),
        )
        for claim in claims
    )
    columns = ("the chapter says", "agrees if", "measured", "verdict", "why")
    note = (
        "Agrees: the 95 % interval of what was measured lies within the bound; where the chapter has a number, what "
        "was measured is as near. Differs: the interval lies outside. Cannot be told: neither, or too few trials "
        "ended. Intervals of shares are those of Clopper and Pearson here."
    )
    return PageTable("The chapter's claims", columns, rows, note)


def trials_table(numbers: Numbers, tick: str) -> PageTable:
    """The trials one by one."""
    records = numbers["records"]
    note = f"The first {MOST_ROWS} of {len(records)} trials." if len(records) > MOST_ROWS else ""
    columns = (
        "trial",
        "outcome",
        "orientation, start (rad)",
        "end (rad)",
        "‖ρ_f‖, start",
        "end",
        "‖ρ_m‖, start (mm)",
        "end (mm)",
        "contact forces (N)",
        "object moved (mm)",
        tick,
        f"{tick} to converge",
        "samples",
        "simulated (s)",
        "details",
    )
    return PageTable("Trials", columns, tuple(map(_trial, records[:MOST_ROWS])), note)


def _trial(record: Numbers) -> tuple[Cell, ...]:
    forces = [force for force in record["contact_forces"] if force is not None]
    return (
        counted_cell(record["number"]),
        words(record["outcome"]),
        _value(record["orientation_start"], "{:.3f}"),
        _value(record["orientation_end"], "{:.3f}"),
        _value(record["force_residual_start"], "{:.3f}"),
        _value(record["force_residual_end"], "{:.3f}"),
        _value(record["moment_residual_start"], "{:.1f}", 1e3),
        _value(record["moment_residual_end"], "{:.1f}", 1e3),
        Cell(", ".join(f"{force:.2f}" for force in forces) or NOTHING, max(forces, default=None)),
        _value(record["object_shift"], "{:.1f}", 1e3),
        counted_cell(record["ticks"]),
        _value(record["ticks_to_converge"], "{:.0f}"),
        counted_cell(record["samples"]),
        _value(record["world_s"], "{:.1f}"),
        words(record["detail"]),
    )


def _value(value: float | None, form: str, scale: float = 1.0) -> Cell:
    return Cell(NOTHING) if value is None else Cell(form.format(scale * value), scale * value)


def _squared(value: float | None, scale: float = 1.0) -> Cell:
    """A squared error, which ranges over orders of magnitude, with two significant digits."""
    return _value(value, "{:.0f}" if value is not None and scale * value >= 100.0 else "{:.2g}", scale)
