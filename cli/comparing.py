"""Runs side by side on a terminal."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from rich.console import RenderableType
from rich.table import Table

from graspdsl.cli.messages import result, result_json, writable
from graspdsl.cli.running import opened
from graspdsl.cli.tables import number, percent, row, table, text_of
from graspdsl.report.compared_measures import MEASURES
from graspdsl.report.comparison import comparison

Numbers = dict[str, Any]


def show_comparison(paths: list[Path], as_json: bool) -> None:
    """Print a comparison of the runs in these folders."""
    numbers = comparison([opened(path) for path in paths])
    if as_json:
        result_json(numbers)
    else:
        result(comparison_text(numbers))


def comparison_text(numbers: Numbers) -> str:
    """A comparison laid out for the terminal that stdout is."""
    runs, others = numbers["runs"], numbers["against_first"]
    names = [f"{place + 1}" for place in range(len(runs))]
    lines: list[RenderableType] = [f"{place}: {writable(run['name'])}, seed {run['seed']}, {writable(run['run'])}"
                           for place, run in zip(names, runs, strict=True)]  # fmt: skip
    tables = [_outcomes(runs, names), _modes(runs, names), _medians(runs, names), _against(others, names[1:])]
    parts = [part for made in tables for part in ("", made)]
    return text_of([*lines, *parts, "", *_methods(others, names[1:])])


def _outcomes(runs: Sequence[Numbers], names: Sequence[str]) -> Table:
    side = table("How trials ended: shares, 95 % intervals", "outcome", *names)
    row(side, "finished", *[str(run["finished"]) for run in runs])
    for outcome in dict.fromkeys(["converged", *[name for run in runs for name in run["outcomes"]]]):
        row(side, outcome, *[_share(run["outcomes"].get(outcome), run) for run in runs])
    return side


def _share(entry: Numbers | None, run: Numbers) -> str:
    if not run["finished"]:
        return "–"
    return "0" if entry is None else f"{entry['count']}: {percent(entry['share'])}, {_percents(entry['interval'])}"


def _percents(interval: Sequence[float]) -> str:
    low, high = interval
    return f"{percent(low)} to {percent(high)}"


def _modes(runs: Sequence[Numbers], names: Sequence[str]) -> Table:
    side = table("Modes of the end orientation: shares, 95 % intervals", "mode", *names)
    for place in range(max(len(run["modes"]) for run in runs)):
        entries = [run["modes"][place] if place < len(run["modes"]) else None for run in runs]
        row(side, f"{place + 1}", *[_mode(entry) for entry in entries])
    return side


def _mode(entry: Numbers | None) -> str:
    if entry is None:
        return "–"
    return f"{entry['centre']:.2f} rad: {percent(entry['share'])}, {_percents(entry['interval'])}"


def _medians(runs: Sequence[Numbers], names: Sequence[str]) -> Table:
    side = table("Medians", "measure", *names)
    for name, measure in MEASURES.items():
        row(side, measure.label, *[number(run["medians"][name], "", measure.digits) for run in runs])
    side.caption, side.caption_justify = "* of converged trials", "left"
    return side


def _against(others: Sequence[Numbers], names: Sequence[str]) -> Table:
    side = table("Against run 1, 95 % intervals", "", *names)
    row(side, "pairs of equal starts", *[str(other["pairs"]) for other in others])
    row(side, "share converged, difference", *[_points(other["converged"]) for other in others])
    for name, measure in MEASURES.items():
        if measure.ratio:
            row(side, f"{measure.label}, ratio", *[_estimate(other["ratios"][name], ".3g") for other in others])
    for name, measure in MEASURES.items():
        form = f"+.{measure.digits}f"
        row(side, f"{measure.label}, difference", *[_estimate(other["differences"][name], form) for other in others])
    turned = [number(other["orientation_difference"], "rad", 3) for other in others]
    row(side, "turned from its pair, median *", *turned)
    return side


def _points(estimate: Numbers | None) -> str:
    if estimate is None:
        return "–"
    low, high = estimate["interval"]
    return f"{100 * estimate['value']:+.0f} points, {100 * low:+.0f} to {100 * high:+.0f}"


def _estimate(estimate: Numbers | None, form: str) -> str:
    if estimate is None:
        return "–"
    if estimate["interval"] is None:
        return f"{estimate['value']:{form}}, too few for an interval"
    low, high = estimate["interval"]
    return f"{estimate['value']:{form}}, {low:{form}} to {high:{form}}"


def _methods(others: Sequence[Numbers], names: Sequence[str]) -> list[RenderableType]:
    """How the intervals came about, each way once, with the columns it holds for."""
    ways: dict[str, list[str]] = {}
    for name, other in zip(names, others, strict=True):
        medians = next((found for found in other["differences"].values() if found), None)
        for what, found in (("shares", other["converged"]), ("medians", medians)):
            if found is not None:
                ways.setdefault(f"{what} by {found['method']}", []).append(name)
    return [f"Run {', '.join(columns)}: differences of {way}." for way, columns in ways.items()]
