"""Runs side by side on a terminal."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from rich.console import RenderableType

from graspdsl.cli.messages import result, result_json, writable
from graspdsl.cli.running import opened
from graspdsl.cli.tables import number, percent, row, table, text_of
from graspdsl.report.comparison import RATIOS, comparison


def show_comparison(paths: list[Path], as_json: bool) -> None:
    """Print a comparison of the runs in these folders."""
    numbers = comparison([opened(path) for path in paths])
    if as_json:
        result_json(numbers)
    else:
        result(_text(numbers))


def _text(numbers: dict[str, Any]) -> str:
    runs = numbers["runs"]
    names = [f"{place + 1}" for place in range(len(runs))]
    lines: list[RenderableType] = [f"{place}: {writable(run['name'])}, seed {run['seed']}, {writable(run['run'])}"
                           for place, run in zip(names, runs, strict=True)]  # fmt: skip
    side = table("Medians over converged trials", "measure", *names)
    row(side, "converged", *[f"{run['converged']} of {run['finished']}" for run in runs])
    row(side, "share, 95 % interval", *[_share(run) for run in runs])
    for name, label in numbers["measures"].items():
        row(side, label, *[number(run["medians"][name], "", 4 if "residual" in name else 2) for run in runs])
    against = table("Ratios to run 1, 95 % interval", "measure", *names[1:])
    for name in RATIOS:
        row(against, numbers["measures"][name], *[_ratio(other["ratios"][name]) for other in numbers["against_first"]])
    row(against, "pairs of equal starts", *[str(other["pairs"]) for other in numbers["against_first"]])
    turned = [number(other["orientation_difference"], "rad", 3) for other in numbers["against_first"]]
    row(against, "median difference of end orientations", *turned)
    return text_of([*lines, "", side, "", against])


def _share(run: dict[str, Any]) -> str:
    low, high = run["interval"]
    return "–" if run["share"] is None else f"{percent(run['share'])}, {percent(low)} to {percent(high)}"


def _ratio(ratio: dict[str, Any] | None) -> str:
    if ratio is None:
        return "–"
    low, high = ratio["interval"]
    return f"{ratio['value']:.3g}, {low:.3g} to {high:.3g}"
