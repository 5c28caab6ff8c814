"""A comparison in words: tables of texts, for a terminal and for a page."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from graspdsl.report.compared_measures import MEASURES
from graspdsl.report.wording import NOTHING, number, percent, percents
from graspdsl.trials.outcomes import Outcome

Numbers = Mapping[str, Any]


@dataclass(frozen=True, slots=True)
class TextTable:
    """A table of texts: what its first column is of, a column for each run, its rows, and a note below."""

    title: str
    columns: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]
    note: str = ""


def tables_of(numbers: Numbers) -> list[TextTable]:
    """The tables of a comparison's numbers."""
    runs, others = numbers["runs"], numbers["against_first"]
    names = tuple(str(place) for place in range(1, len(runs) + 1))
    return [_outcomes(runs, names), _modes(runs, names), _medians(runs, names), _against(others, names[1:])]


def methods_of(numbers: Numbers) -> list[str]:
    """How the intervals of differences came about, each way once, with the runs that it holds for."""
    ways: dict[str, list[str]] = {}
    for place, other in enumerate(numbers["against_first"], 2):
        medians = next((found for found in other["differences"].values() if found), None)
        for what, found in (("shares", other["converged"]), ("medians", medians)):
            if found is not None:
                ways.setdefault(f"{what}: {found['method']}", []).append(str(place))
    found_ways = [f"Run {', '.join(places)} against run 1, {way}." for way, places in ways.items()]
    return ["Intervals hold 95 %; those of shares of one run are Wilson's.", *found_ways]


def _outcomes(runs: Sequence[Numbers], names: tuple[str, ...]) -> TextTable:
    known = dict.fromkeys([Outcome.CONVERGED.value, *[name for run in runs for name in run["outcomes"]]])
    rows = [("finished trials", *[f"{run['finished']} of {run['asked']}" for run in runs])]
    rows += [(name, *[_share(run, name) for run in runs]) for name in known]
    return TextTable("How trials ended: shares with 95 % intervals", ("outcome", *names), tuple(rows))


def _share(run: Numbers, outcome: str) -> str:
    if not run["finished"]:
        return NOTHING
    entry = run["outcomes"].get(outcome)
    return "0" if entry is None else f"{entry['count']}: {percent(entry['share'])}, {percents(entry['interval'])}"


def _modes(runs: Sequence[Numbers], names: tuple[str, ...]) -> TextTable:
    most = max(len(run["modes"]) for run in runs)
    rows = [(str(place + 1), *[_mode(run["modes"], place) for run in runs]) for place in range(most)]
    return TextTable("Modes of the end orientation: shares with 95 % intervals", ("mode", *names), tuple(rows))


def _mode(modes: Sequence[Numbers], place: int) -> str:
    if place >= len(modes):
        return NOTHING
    mode = modes[place]
    return f"{mode['centre']:.2f} rad: {percent(mode['share'])}, {percents(mode['interval'])}"


def _medians(runs: Sequence[Numbers], names: tuple[str, ...]) -> TextTable:
    rows = [
        (measure.label, *[number(run["medians"][name], "", measure.digits) for run in runs])
        for name, measure in MEASURES.items()
    ]
    return TextTable("Medians", ("measure", *names), tuple(rows), "* of converged trials")


def _against(others: Sequence[Numbers], names: tuple[str, ...]) -> TextTable:
    rows = [
        ("pairs of equal starts", *[_pairs(other) for other in others]),
        ("share converged, difference", *[_points(other["converged"]) for other in others]),
        ("pairs of which only this one converged", *[str(other["only_other_converged"]) for other in others]),
        ("pairs of which only run 1 converged", *[str(other["only_first_converged"]) for other in others]),
    ]
    for name, measure in MEASURES.items():
        if measure.ratio:
            rows.append((f"{measure.label}, ratio", *[_estimate(other["ratios"][name], ".3g") for other in others]))
    for name, measure in MEASURES.items():
        found = [_estimate(other["differences"][name], f"+.{measure.digits}f") for other in others]
        rows.append((f"{measure.label}, difference", *found))
    turned = [number(other["orientation_difference"], "", 3) for other in others]
    rows.append(("turned from its pair, median [rad] *", *turned))
    note = "* of converged trials; where trials are paired, of pairs that both converged"
    return TextTable("Against run 1: differences and ratios with 95 % intervals", ("", *names), tuple(rows), note)


def _pairs(other: Numbers) -> str:
    return f"{other['pairs']}" if other["paired"] or not other["pairs"] else f"{other['pairs']}, too few to be used"


def _points(estimate: Numbers | None) -> str:
    if estimate is None:
        return NOTHING
    low, high = estimate["interval"]
    return f"{100 * estimate['value']:+.0f} points, {100 * low:+.0f} to {100 * high:+.0f}"


def _estimate(estimate: Numbers | None, form: str) -> str:
    if estimate is None:
        return NOTHING
    if estimate["interval"] is None:
        return f"{estimate['value']:{form}}, too few for an interval"
    low, high = ("∞" if end is None else f"{end:{form}}" for end in estimate["interval"])
    return f"{estimate['value']:{form}}, {low} to {high}"
