"""What the figures of a run's page draw, as numbers: drawings and exports are both made of these."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from graspdsl.arrays import Array, Rows
from graspdsl.hands.descriptions import joint_units
from graspdsl.report.attraction import AttractionMap, map_of_run
from graspdsl.report.data_files import Columns
from graspdsl.report.evidence import Evidence
from graspdsl.report.priorities import Priorities, scale_of
from graspdsl.report.statistics import MOST_TICKS, ORIENTATIONS, Band, band, bandwidth, density
from graspdsl.report.summary import Summary
from graspdsl.spec.trials import PARAMETERS
from graspdsl.trials.columns import Column

MILLIMETRES = 1000.0  # in a metre
START_BINS = 24
DISTURBED = (5.0, 50.0, 95.0)  # percentiles

Parts = Mapping[str, Callable[[], Columns]]  # tables by what is added to the name of a figure: nothing, or a part of it


@dataclass(frozen=True)
class Density:
    """Orientations [rad] (n,) of trials, and their ``heights`` [1/rad] over ORIENTATIONS; none of no trial."""

    values: Array

    @property
    def width(self) -> float:
        """The bandwidth [rad]."""
        return bandwidth(self.values)

    @cached_property
    def heights(self) -> Array:
        """(257,) or (0,)."""
        return self.at(ORIENTATIONS)

    def at(self, orientations: Array) -> Array:
        """The density [1/rad] (m,) at orientations [rad] (m,); (0,) of no trial."""
        return density(self.values, orientations, self.width) if len(self.values) else np.zeros(0)


@dataclass(frozen=True)
class Funnel:
    """Where the trials ``numbers`` started and ended: orientations [rad] before and after, or where a monitor stopped
    the trial, (n,) each by trial, NaN for those that do not count; ``mode``: the mode each trial ended in, by rank from
    0, −1 for none; ``centres``: the peaks [rad] of the modes by rank."""

    numbers: Sequence[int]
    before: Array
    after: Array
    stopped: Array
    mode: Sequence[int]
    centres: Sequence[float]
    name: str = "funnel"

    @cached_property
    def densities(self) -> tuple[Density, Density]:
        """Those of orientations before and after."""
        before, after = (Density(known[np.isfinite(known)]) for known in (self.before, self.after))
        return before, after

    @cached_property
    def peaks(self) -> Array:
        """How high the density after is at the peaks of the modes [1/rad], (m,); (0,) where no trial settled."""
        return self.densities[1].at(np.asarray(self.centres))

    @property
    def parts(self) -> Parts:
        """The trials, the densities, and the modes where there are any."""
        modes = {"modes": self._modes} if len(self.peaks) else {}
        return {"": self._trials, "densities": self._densities, **modes}

    def _trials(self) -> Columns:
        mode = np.array(self.mode)
        return {
            "number": Column(np.array(self.numbers, dtype=np.int64), "1"),
            "before": Column(self.before, "rad"),
            "after": Column(self.after, "rad"),
            "stopped": Column(self.stopped, "rad"),
            "mode": Column(np.where(mode < 0, math.nan, mode + 1.0), "1"),
        }

    def _densities(self) -> Columns:
        known = [(name, one) for name, one in zip(("before", "after"), self.densities, strict=True) if len(one.heights)]
        return {
            "of": Column(np.repeat([name for name, _ in known], len(ORIENTATIONS)), ""),
            "orientation": Column(np.tile(ORIENTATIONS, len(known)), "rad"),
            "density": Column(np.concatenate([one.heights for _, one in known]), "1/rad"),
            "bandwidth": Column(np.repeat([one.width for _, one in known], len(ORIENTATIONS)), "rad"),
        }

    def _modes(self) -> Columns:
        return {
            "mode": Column(np.arange(1, len(self.centres) + 1), "1"),
            "orientation": Column(np.array(self.centres), "rad"),
            "density": Column(self.peaks, "1/rad"),
        }


@dataclass(frozen=True)
class ResidualCurves:
    """How the residuals of some trials fell by tick or probe (``tick``): ‖ρ_f‖ (1) and ‖ρ_m‖ [mm].

    ``rank``: of their mode, from 0; None where they are in none. bounds: what the end conditions ask of each; ``top``
    (2,): the upper ends of the axes, so that figures compare.
    """

    name: str
    title: str
    rank: int | None
    tick: str
    force: Band
    moment: Band
    bounds: tuple[float | None, float | None]
    top: Array

    @property
    def parts(self) -> Parts:
        """One table, a row a tick that is drawn."""
        return {"": self._columns}

    def _columns(self) -> Columns:
        ticks = np.union1d(self.force.ticks, self.moment.ticks)
        running = _over(ticks, self.force, self.force.running)
        found = {"tick": Column(ticks.astype(np.int64), "1"), "running": Column(running, "1")}
        curves = (("force_residual", self.force, "1"), ("moment_residual", self.moment, "mm"))
        for (name, curve, unit), bound in zip(curves, self.bounds, strict=True):
            for what, values in (("mean", curve.mean), ("p10", curve.low), ("p90", curve.high)):
                found[f"{name}.{what}"] = Column(_over(ticks, curve, values), unit)
            if bound is not None:
                found[f"{name}.bound"] = Column(np.full(len(ticks), bound), unit)
        return found


def _over(ticks: Array, curve: Band, values: Array) -> Array:
    """The values of a curve over more ticks, NaN where it has none."""
    found = np.full(len(ticks), math.nan)
    found[np.searchsorted(ticks, curve.ticks)] = values
    return found


@dataclass(frozen=True)
class Convergence:
    """After how many ticks or probes (``tick``) trials converged, (n,) in ascending order, out of ``finished``."""

    ticks: Rows
    finished: int
    tick: str
    name: str = "convergence"

    @property
    def shares(self) -> Array:
        """The share of finished trials that have converged by each, (n,)."""
        return np.arange(1, len(self.ticks) + 1) / self.finished

    @property
    def parts(self) -> Parts:
        """One table, a row a trial that converged."""
        return {"": self._columns}

    def _columns(self) -> Columns:
        return {"tick": Column(self.ticks, "1"), "share": Column(self.shares, "1")}


@dataclass(frozen=True)
class StartMap:
    """Which starts of a grid ended where."""

    made: AttractionMap
    name: str = "map"

    @property
    def parts(self) -> Parts:
        """The cells, and the classes that they are of."""
        return {"": self._cells, "classes": self._classes}

    def _cells(self) -> Columns:
        cells, labels = self.made.cells, np.full(len(self.made.cells.outcomes), "", dtype=object)
        for found in self.made.classes:
            labels[list(found.cells)] = found.label
        rows, columns = np.divmod(np.arange(len(labels)), cells.x.cells)
        starts = {
            f"{axis.parameter}{which}": Column(values[place], axis.unit)
            for axis, place in ((cells.x, columns), (cells.y, rows))
            for which, values in (("", axis.middles), (".low", axis.edges[:-1]), (".high", axis.edges[1:]))
        }
        return {
            **starts,
            "class": Column(labels.astype(np.str_), ""),
            "outcome": Column(np.array(cells.outcomes), ""),
            "orientation": Column(cells.orientation, "rad"),
            "ticks_to_converge": Column(cells.ticks, "1"),
        }

    def _classes(self) -> Columns:
        classes = self.made.classes
        low, high = np.array([found.interval for found in classes]).T
        return {
            "class": Column(np.array([found.label for found in classes]), ""),
            "cells": Column(np.array([len(found.cells) for found in classes]), "1"),
            "share": Column(np.array([found.share for found in classes]), "1"),
            "share.low": Column(low, "1"),
            "share.high": Column(high, "1"),
        }


@dataclass(frozen=True)
class Draws:
    """A number of the starts that were drawn, in its unit: how many draws in each bin trials began with, and how many
    could not be taken up, (b,) each between ``edges`` (b + 1,). ``label``: with the unit, as it is shown."""

    parameter: str
    unit: str
    label: str
    edges: Array
    kept: Array
    rejected: Array

    @classmethod
    def of(cls, parameter: str, unit: str, label: str, kept: Array, rejected: Array) -> Draws:
        """Of what trials began with (n,) and of what could not be taken up (m,)."""
        edges = np.histogram_bin_edges(np.concatenate([kept, rejected]), START_BINS)
        return cls(parameter, unit, label, edges, *(np.histogram(drawn, edges)[0] for drawn in (kept, rejected)))

    def columns(self) -> Columns:
        """A row a bin."""
        return {
            f"{self.parameter}.low": Column(self.edges[:-1], self.unit),
            f"{self.parameter}.high": Column(self.edges[1:], self.unit),
            "kept": Column(self.kept, "1"),
            "rejected": Column(self.rejected, "1"),
        }


@dataclass(frozen=True)
class StartDraws:
    """What became of the draws of a start, by each of its numbers: so many were ``kept``, so many ``rejected``."""

    draws: Sequence[Draws]
    kept: int
    rejected: int
    name: str = "starts"

    @property
    def parts(self) -> Parts:
        """A table for each number of a start."""
        return {one.parameter: one.columns for one in self.draws}


@dataclass(frozen=True)
class Disturbed:
    """How far a level was disturbed in one step, in ``unit``, of trials still running: at ticks (t,), percentiles
    DISTURBED (3, t) over trials and the largest (t,)."""

    level: str
    unit: str
    ticks: Rows
    quantiles: Array
    most: Array

    def columns(self) -> Columns:
        """A row a tick."""
        quantiles = zip(("p5", "p50", "p95"), self.quantiles, strict=True)
        return {
            "level": Column(np.full(len(self.ticks), self.level), ""),
            "tick": Column(self.ticks, "1"),
            **{f"disturbance.{name}": Column(values, self.unit or "1") for name, values in quantiles},
            "disturbance.largest": Column(self.most, self.unit or "1"),
        }


@dataclass(frozen=True)
class Disturbances:
    """How far each level that others are subject to was disturbed over time; ``tick``: what a step is."""

    levels: Sequence[Disturbed]
    tick: str
    name: str = "priorities"

    @property
    def parts(self) -> Parts:
        """A table for each level, counted from 1."""
        return {str(place): one.columns for place, one in enumerate(self.levels, 1)}


def tick_of(evidence: Evidence) -> str:
    """What a row of a course is: what happens once for each."""
    return "probes" if evidence.program.probes else "controller ticks"


FigureData = Funnel | ResidualCurves | Convergence | StartMap | StartDraws | Disturbances


def figures_of(evidence: Evidence, summary: Summary) -> list[FigureData]:
    """The figures of a run's page, those that have anything to show, in their order."""
    converged = convergence_of(evidence)
    found: list[FigureData | None] = [
        funnel_of(evidence, summary),
        *_residuals(evidence, summary),
        converged if len(converged.ticks) else None,
        _map(evidence),
        _starts(evidence, summary),
        _disturbances(evidence, summary.priorities),
    ]
    return [figure for figure in found if figure is not None]


def figure_tables(figures: Iterable[FigureData]) -> dict[str, Callable[[], Columns]]:
    """What is drawn, by names: ``figure-``, that of a figure, and the part of it that a table is of."""
    return {
        re.sub(r"[^\w.]+", "-", f"figure-{figure.name}-{part}").strip("-"): columns
        for figure in figures
        for part, columns in figure.parts.items()
    }


def funnel_of(evidence: Evidence, summary: Summary) -> Funnel | None:
    """Where grasps started and ended; None where no grasp had an orientation."""
    before = _angles(summary.orientation_start)
    touched = np.array([bool(touching) for touching in summary.in_contact_end], dtype=bool)
    settled = np.array([record.outcome.settled for record in evidence.records], dtype=bool)
    ends = np.where(touched, _angles(summary.orientation_end), math.nan)
    if not (np.isfinite(before).any() or np.isfinite(ends).any()):
        return None
    ranks = {number: rank for rank, mode in enumerate(summary.modes) for number in mode.trials}
    numbers = [record.number for record in evidence.records]
    return Funnel(
        numbers,
        before,
        np.where(settled, ends, math.nan),
        np.where(settled, math.nan, ends),
        [ranks.get(number, -1) for number in numbers],
        [mode.centre for mode in summary.modes],
    )


def _angles(values: Sequence[float | None]) -> Array:
    return np.array([math.nan if value is None else value for value in values], dtype=float)


def _residuals(evidence: Evidence, summary: Summary) -> list[ResidualCurves]:
    """How residuals fell, for each mode, and for the trials that ended in none."""
    groups: list[tuple[str, str, int | None, Sequence[int]]] = [
        (f"residuals-mode-{rank + 1}", f"Mode {rank + 1}, {mode.centre:.2f} rad", rank, mode.trials)
        for rank, mode in enumerate(summary.modes)
    ]
    within = {number for *_, members in groups for number in members}
    others = [record.number for record in evidence.records if record.number not in within]
    groups.append(("residuals-others", "Trials in no mode" if within else "All trials", None, others))
    found = []
    for name, title, rank, members in groups:
        curves = _curves(evidence, members)
        if curves is not None:
            found.append((name, title, rank, *curves))
    tops = [np.array([force.high.max(), moment.high.max()]) for *_, force, moment in found]
    top = 1.08 * np.max(tops, axis=0) if tops else np.ones(2)
    until, tick = evidence.program.spec.program[-1].until, tick_of(evidence)
    bounds = (until.force_residual, None if until.moment_residual is None else MILLIMETRES * until.moment_residual)
    return [
        ResidualCurves(name, title, rank, tick, force, moment, bounds, np.where(top > 0.0, top, 1.0))
        for name, title, rank, force, moment in found
    ]


def _curves(evidence: Evidence, members: Sequence[int]) -> tuple[Band, Band] | None:
    """The bands of ‖ρ_f‖ (1) and ‖ρ_m‖ [mm] of trials; None where none was measured."""
    courses = [evidence.courses[number] for number in members if number in evidence.courses]
    force, moment = band([course.force for course in courses]), band([MILLIMETRES * c.moment for c in courses])
    return None if force is None or moment is None else (force, moment)


def convergence_of(evidence: Evidence) -> Convergence:
    """How soon trials converged."""
    known = [record.ticks_to_converge for record in evidence.records]
    ticks = np.array(sorted(count for count in known if count is not None), dtype=np.intp)
    return Convergence(ticks, len(evidence.records), tick_of(evidence))


def _map(evidence: Evidence) -> StartMap | None:
    """Which starts of a grid ended where; None for a run that is no finished grid of two axes."""
    grid = evidence.program.spec.trials.grid or ()
    cells = math.prod(axis.cells for axis in grid)
    if len(grid) != 2 or not len(evidence.records) == evidence.folder.manifest.asked == cells:
        return None
    return StartMap(map_of_run(evidence.folder, evidence.program, evidence.records))


def _starts(evidence: Evidence, summary: Summary) -> StartDraws | None:
    """What became of the draws of a start; None where every draw began a trial, or nothing differs between them."""
    kept = [record.start for record in evidence.records if record.start]
    rejected = [start.drawn for record in evidence.records for start in record.rejected]
    names = [name for name in summary.starts.parameters if all(name in start for start in rejected)]
    if not names or not rejected:
        return None
    units = {**joint_units(evidence.program.robot), **PARAMETERS}
    draws = [
        Draws.of(
            *(name, units.get(name, "1"), f"{name} ({summary.starts.parameters[name].unit or 'rad or m'})"),
            *(np.array([start[name] for start in starts]) for starts in (kept, rejected)),
        )
        for name in names
    ]
    return StartDraws(draws, len(kept), len(rejected))


def _disturbances(evidence: Evidence, priorities: Priorities) -> Disturbances | None:
    """How far each level was disturbed over time; None where none was."""
    levels = []
    for level in priorities.certified:
        seen = [course.disturbed(level.stage, level.place) for course in evidence.courses.values()]
        if known := [one for one in seen if np.isfinite(one).any()]:
            unit, scale = scale_of(level.observed.unit)
            ticks, quantiles, most = _disturbed(known)
            levels.append(Disturbed(level.name, unit, ticks, scale * quantiles, scale * most))
    return Disturbances(levels, tick_of(evidence)) if levels else None


def _disturbed(seen: Sequence[Array]) -> tuple[Rows, Array, Array]:
    """Ticks (t,) at which any trial tells of a level, the percentiles (3, t) over trials, and the largest (t,)."""
    together = np.full((len(seen), max(map(len, seen))), np.nan)
    for row, one in zip(together, seen, strict=True):
        row[: len(one)] = one
    known = np.flatnonzero(np.isfinite(together).any(axis=0))
    if len(known) > MOST_TICKS:
        known = known[np.linspace(0, len(known) - 1, MOST_TICKS).astype(int)]
    chosen = together[:, known]
    quantiles = np.asarray(np.nanpercentile(chosen, DISTURBED, axis=0))
    return known, quantiles, np.asarray(np.nanmax(chosen, axis=0))
