"""A map of the domain of attraction: which starts end in which mode or outcome, as plain data."""

from __future__ import annotations

import math
import shlex
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from graspdsl.compiler.program import Program
from graspdsl.places.files import MAP_DATA
from graspdsl.report.modes import modes
from graspdsl.report.outcomes import Said, grouped
from graspdsl.report.statistics import Interval, wilson
from graspdsl.trials.maps import Axis, Cells, cells_of
from graspdsl.trials.outcomes import Outcome
from graspdsl.trials.record import TrialRecord
from graspdsl.trials.store import SPEC, RunFolder

FILES = ("map.svg", "map.png", MAP_DATA)


@dataclass(frozen=True, slots=True)
class CellClass:
    """Cells that ended alike: in an outcome, and where that is convergence in a mode of orientation (``mode`` from 1,
    ``centre`` [rad]). ``label``: what a legend calls it; ``cells``: by position, ``of`` so many; ``mostly``: what was
    said of most of them, None where nothing was."""

    outcome: str
    label: str
    mode: int | None
    centre: float | None
    cells: tuple[int, ...]
    of: int
    mostly: Said | None

    @property
    def share(self) -> float:
        """The share of all cells."""
        return len(self.cells) / self.of

    @property
    def interval(self) -> Interval:
        """Its Wilson interval, as if starts had been drawn evenly over the map."""
        return wilson(len(self.cells), self.of)


@dataclass(frozen=True, slots=True)
class AttractionMap:
    """A map with what it is a map of; ``command`` makes it again."""

    name: str
    world: str
    seed: int
    command: str
    tick: str
    cells: Cells
    classes: tuple[CellClass, ...]

    @property
    def feasible(self) -> int:
        """How many starts were."""
        return sum(outcome != Outcome.INFEASIBLE_START.value for outcome in self.cells.outcomes)

    @property
    def converged(self) -> int:
        """How many starts did."""
        return sum(outcome == Outcome.CONVERGED.value for outcome in self.cells.outcomes)


def map_of_run(folder: RunFolder, program: Program, records: Sequence[TrialRecord]) -> AttractionMap:
    """The map that a finished run of a program on a grid is. Raises DiagnosticError when it is none."""
    manifest, cells = folder.manifest, cells_of(program.spec, records)
    settings = [setting for setting in manifest.settings if not setting.startswith("trials.grid=")]
    command = repeating(folder.whole / SPEC, cells, manifest.seed, settings, allow_code=folder.allow_code)
    return attraction_map(program, cells, manifest.seed, command)


def attraction_map(program: Program, cells: Cells, seed: int, command: str) -> AttractionMap:
    """The map of a program's cells; ``command`` makes it again."""
    tick = "probes" if program.probes else "ticks"
    return AttractionMap(program.spec.name, program.spec.scene.world, seed, command, tick, cells, classes_of(cells))


def repeating(spec: Path, cells: Cells, seed: int, settings: Sequence[str], *, allow_code: bool) -> str:
    """The command that makes a map again, from this spec with these settings."""
    words = ["graspdsl", "map", str(spec), "--over", f"{cells.x.said},{cells.y.said}"]
    words += ["--grid", f"{cells.x.cells}x{cells.y.cells}", "--seed", str(seed)]
    words += ["--contact", cells.fixed["contact"]] if "contact" in cells.fixed else []
    words += [word for name in settings if not name.startswith("trials.seed=") for word in ("--set", name)]
    words += ["--allow-code"] if allow_code else []
    return shlex.join(words)


def classes_of(cells: Cells) -> tuple[CellClass, ...]:
    """The classes of a map: converged cells by mode, the largest first; then other outcomes, infeasible starts last.

    Modes are those of the end orientations of all converged cells; cells whose grasp has no orientation are one class.
    """
    outcomes = np.array(cells.outcomes)
    converged = Outcome.CONVERGED.value

    def alike(outcome: str, label: str, mode: int | None, centre: float | None, members: Iterable[int]) -> CellClass:
        places = tuple(int(cell) for cell in members)
        said = grouped((cell, cells.details[cell]) for cell in places)
        return CellClass(outcome, label, mode, centre, places, len(outcomes), said[0] if said else None)

    good = np.flatnonzero(outcomes == converged)
    known = good[np.isfinite(cells.orientation[good])]
    found = [
        alike(converged, f"{converged}, {mode.centre:.2f} rad", rank, mode.centre, sorted(known[list(mode.members)]))
        for rank, mode in enumerate(modes(cells.orientation[known]), 1)
    ]
    if unknown := [int(cell) for cell in good if not math.isfinite(cells.orientation[cell])]:
        found.append(alike(converged, converged, None, None, unknown))
    counts = Counter(cells.outcomes)
    others = sorted(
        (name for name in counts if name != converged),
        key=lambda name: (name == Outcome.INFEASIBLE_START.value, -counts[name], name),
    )
    found += [alike(name, name, None, None, np.flatnonzero(outcomes == name)) for name in others]
    return tuple(found)


def as_data(made: AttractionMap) -> dict[str, Any]:
    """The map as plain data, for JSON.

    ``grid``: the class of each cell by its place in ``classes``, rows along the second axis. Shares are of all cells,
    with 95 % Wilson intervals as if starts had been drawn evenly over the map; ``converged`` is the share of those
    cells that were feasible. ``details``: what was said of each cell, and ``mostly`` what was of most of a class and of
    how many of its cells; None where nothing was.
    """
    cells, count = made.cells, len(made.cells.outcomes)
    place = np.zeros(count, dtype=int)
    for index, found in enumerate(made.classes):
        place[list(found.cells)] = index
    return {
        "name": made.name,
        "world": made.world,
        "seed": made.seed,
        "command": made.command,
        "axes": [_axis(cells.x), _axis(cells.y)],
        "fixed": dict(cells.fixed),
        "marks": {name: list(where) for name, where in cells.marks.items()},
        "cells": count,
        "feasible": made.feasible,
        "converged": {
            "count": made.converged,
            "share": made.converged / made.feasible if made.feasible else None,
            "interval": wilson(made.converged, made.feasible),
        },
        "classes": [
            {
                "label": found.label,
                "outcome": found.outcome,
                "mode": found.mode,
                "centre": found.centre,
                "count": len(found.cells),
                "share": found.share,
                "interval": found.interval,
                "mostly": found.mostly and {"detail": found.mostly.detail, "count": len(found.mostly.trials)},
            }
            for found in made.classes
        ],
        "tick": made.tick,
        "grid": _rows(place.tolist(), cells.x.cells),
        "ticks": _rows([_known(value) for value in cells.ticks], cells.x.cells),
        "orientation": _rows([_known(value) for value in cells.orientation], cells.x.cells),
        "details": _rows([detail or None for detail in cells.details], cells.x.cells),
    }


def _axis(axis: Axis) -> Mapping[str, Any]:
    return {
        "parameter": axis.parameter,
        "unit": axis.unit,
        "low": axis.low,
        "high": axis.high,
        "cells": axis.cells,
        "middles": [float(middle) for middle in axis.middles],
    }


def _rows(values: list[Any], columns: int) -> list[list[Any]]:
    return [values[first : first + columns] for first in range(0, len(values), columns)]


def _known(value: float) -> float | None:
    return float(value) if math.isfinite(value) else None
