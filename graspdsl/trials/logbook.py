"""What trials write down tick by tick, and the numbers their records take from it."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from graspdsl.arrays import Array, Float32Array, Rows
from graspdsl.basis.algebra import length
from graspdsl.basis.resources import ContactSet
from graspdsl.compiler.pipeline import Pipeline, Ticks
from graspdsl.trials.measures import GraspMeasure, measure, sensing_errors, true_contacts
from graspdsl.trials.priorities import PriorityLog
from graspdsl.trials.record import Balance
from graspdsl.trials.tick_rows import Ahead, Row, TickRows, Told
from graspdsl.worlds.protocol import PARTIES, Observation, Truth

NEVER = -1  # in place of a tick
BALANCED_S = 1.0  # s at the end, over which what acts on the object is told


class Logbook:
    """The running numbers of N trials, (N,) each, and their trajectories where these are kept. Each trial has a place,
    which another may get when it is over.

    Ticks count from 0, as the rows of a trajectory do; NEVER stands where there was none. ``first_touch``: the one at
    which every contact first touched; ``control_start``: at which the controller took over from the guarded close;
    ``held_since``: from which on the end conditions have held; ``last``: the latest one. ``origins`` (N, 3) [m]:
    where the objects were to begin with; ``shift`` [m] and ``lean`` [rad] of the object; ``world_s``: the world's time
    [s] at the last tick.
    """

    def __init__(
        self,
        grasps: Sequence[ContactSet],
        pipelines: Sequence[Pipeline],
        count: int = 1,
        ticks: int = 1,
        *,
        trajectories: bool = True,
    ) -> None:
        """``grasps``: of the phases; ``pipelines``: of the stages; ``count``: how many places N there are; ``ticks``:
        how many a trial may have."""
        self._grasps, self._keeps, self.origins = grasps, trajectories, np.zeros((count, 3))
        self._rows, self._exact = TickRows(count, ticks, np.float32), TickRows(count, ticks, np.float64)
        self._priorities, self._ahead = PriorityLog(pipelines, count, ticks), Ahead(self._write_down)
        self._touch_phase, self._phase = np.zeros((2, count), dtype=np.intp)
        self.first_touch, self.control_start, self.held_since, self.last = np.full((4, count), NEVER, dtype=np.intp)
        self.world_s, self.shift, self.lean = np.zeros((3, count))

    def begin(self, trials: Rows) -> None:
        """Nothing is known any more of what was at these places: other trials begin there."""
        self._ahead.write()
        for noted in (self.first_touch, self.control_start, self.held_since, self.last):
            noted[trials] = NEVER
        for number in (self.world_s, self.shift, self.lean):
            number[trials] = 0.0
        self._priorities.begin(trials)

    def write(
        self, tick: Rows, trials: Rows, phase: int, stage: int, seen: Observation, truth: Truth, ticks: Ticks
    ) -> GraspMeasure:
        """Write down a tick of M of the trials, by the number (M,) that it has for each; what stood there is
        overwritten, as the next controller sees the same observation again. Returns the measures of their grasps."""
        grasp = self._grasps[phase]
        now = measure(seen, truth, grasp)
        self._note_touch(tick, trials, phase, seen)
        self.last[trials], self._phase[trials], self.world_s[trials] = tick, phase, seen.time
        self.shift[trials] = length(truth.object_position - self.origins[trials])
        self.lean[trials] = truth.object_lean
        if self._keeps:
            self._ahead.tell(tick, trials, phase, stage, Told(seen, truth, ticks, now))
        return now

    def _note_touch(self, tick: Rows, trials: Rows, phase: int, seen: Observation) -> None:
        """When every contact first touched, and when the controller took over from what made them touch."""
        without = self.first_touch[trials] == NEVER
        if without.any():
            touching = seen.touching[:, list(self._grasps[phase].contacts)].all(axis=-1)
            first = touching & without
            self.first_touch[trials[first]], self._touch_phase[trials[first]] = tick[first], phase
        if phase > 0:
            controlled = (self.first_touch[trials] != NEVER) & (self._touch_phase[trials] < phase)
            begins = controlled & (self.control_start[trials] == NEVER)
            self.control_start[trials[begins]] = tick[begins]

    def _write_down(self, tick: Rows, trials: Rows, phase: int, stage: int, told: Told) -> None:
        """What is told of T ticks from these on, and what follows from it."""
        seen, truth, ticks, now = told.seen, told.truth, told.ticks, told.now
        self._priorities.note(tick, trials, stage, seen, ticks)
        points, normals = true_contacts(seen, truth)
        felt, distance, sine, cosine = sensing_errors(seen, truth)
        measured: Row = {
            "force_residual": now.force_residual,
            "moment_residual": now.moment_residual,
            "orientation": now.orientation,
        }
        row: Row = {
            "time": seen.time,
            "phase": np.full(seen.touching.shape[:2], phase),
            "stage": np.full(seen.touching.shape[:2], stage),
            **measured,
            "sensed_force_residual": ticks.force_residual,
            "sensed_moment_residual": ticks.moment_residual,
            "null_space_ranks": _padded(ticks.ranks, self._priorities.levels),
            "joints": seen.joints,
            "touching": seen.touching,
            "sensed_points": seen.points,
            "sensed_normals": seen.normals,
            "sensed_forces": seen.forces,
            "points": points,
            "normals": normals,
            "forces": truth.forces,
            "object_position": truth.object_position,
            "object_rotation": truth.object_rotation,
            "object_axis": truth.object_axis,
            "loads": truth.loads,
        }
        exact: Row = {
            **measured,
            "time": seen.time,
            "loads": truth.loads,
            "pressing": np.vecdot(np.nan_to_num(truth.forces), normals),
            "touches": np.logical_and.reduce(np.isfinite(truth.forces), axis=-1),  # else there are none
            "felt": felt,
            "distance": distance,
            "sine": sine,
            "cosine": cosine,
        }
        self._rows.put(tick, trials, row)
        self._exact.put(tick, trials, exact)

    def trajectory(self, trial: int) -> Mapping[str, Float32Array]:
        """The arrays of a trial, one row a tick; none where it had no tick."""
        self._ahead.write()
        ticks = int(self.last[trial]) + 1
        rows = self._rows.of(trial, ticks)
        if rows:
            rows |= {name: array.astype(np.float32) for name, array in self._priorities.channels(trial, ticks).items()}
        return rows

    def ticks_to_converge(self, trial: int) -> int | None:
        """Ticks or probes of the controller until the end conditions began to hold for good."""
        begun, held = self._begun(trial), int(self.held_since[trial])
        return None if NEVER in (begun, held) else max(0, held - begun)

    def numbers(self, trial: int) -> dict[str, Any]:
        """What the record of a trial takes from here, by the record's names.

        The start is the first tick at which every contact touched, else the first of all.
        """
        self._ahead.write()
        last, begun = int(self.last[trial]), self._begun(trial)
        samples = 0 if begun == NEVER else last + 1 - begun
        exact = self._exact.of(trial, last + 1)
        start = max(0, int(self.first_touch[trial]))
        measured = {
            f"{name}_{when}": float(exact[name][tick]) if exact else math.nan
            for name in ("orientation", "force_residual", "moment_residual")
            for when, tick in (("start", start), ("end", last))
        }
        contacts = self._grasps[self._phase[trial]].contacts if exact else ()
        return {
            **measured,
            "contact_forces": tuple(float(exact["pressing"][last, contact]) for contact in contacts),
            "object_shift": float(self.shift[trial]),
            "object_lean": float(self.lean[trial]),
            "ticks": max(0, samples - 1),
            "priorities": self._priorities.disturbances(trial, exact["time"]) if exact else (),
            "point_error": _percentiles(exact["distance"][exact["felt"] > 0.0] if exact else np.zeros(0)),
            "normal_error": _percentiles(_angles(exact) if exact else np.zeros(0)),
            "samples": samples,
            "balance": self._balance(trial, exact) if exact else None,
            "world_s": float(self.world_s[trial]),
            "touching": tuple(bool(exact["touches"][last, contact]) for contact in contacts),
        }

    def _balance(self, trial: int, exact: Mapping[str, Array]) -> Balance | None:
        """What each party puts on the object at the end; None where it is not known."""
        first = int(np.searchsorted(exact["time"], exact["time"][-1] - BALANCED_S, side="right"))
        loads = exact["loads"][max(first, int(self.held_since[trial])) :].mean(axis=0)
        known = np.isfinite(loads).all()
        return Balance(**dict(zip(PARTIES, map(tuple, loads.tolist()), strict=True))) if known else None

    def _begun(self, trial: int) -> int:
        """The tick at which the controller takes over from the close, or of the first touch where there is only one."""
        control = int(self.control_start[trial])
        return int(self.first_touch[trial]) if control == NEVER else control


def _padded(values: Array, width: int) -> Array:
    """The values (..., w) and then NaN, so that the rows of all phases are alike."""
    missing = np.full((*values.shape[:-1], width - values.shape[-1]), np.nan)
    return np.concatenate([values, missing], axis=-1)


def _angles(exact: Mapping[str, Array]) -> Array:
    """The angles [rad] between sensed and true normals, of all that was felt.

    Tick by tick, for the arctangents of many numbers are rounded otherwise than those of few.
    """
    felt = exact["felt"] > 0.0
    if not exact["sine"].any() and (exact["cosine"] >= 0.0).all():  # normals that are sensed as they are
        return np.zeros(np.count_nonzero(felt))
    each = zip(exact["sine"], exact["cosine"], felt, strict=True)
    return np.concatenate([np.arctan2(sine[known], cosine[known]) for sine, cosine, known in each])


def _percentiles(values: Array) -> tuple[float, float]:
    """Median and 95th percentile; NaN of nothing."""
    if len(values) == 0:
        return math.nan, math.nan
    if not values.any():
        return 0.0, 0.0
    half, most = np.percentile(values, [50, 95])
    return float(half), float(most)
