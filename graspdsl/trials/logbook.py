"""What trials write down tick by tick, and the numbers their records take from it."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from graspdsl.arrays import Array, Flags, Float32Array, Rows
from graspdsl.basis.resources import ContactSet
from graspdsl.compiler.pipeline import Ticks
from graspdsl.trials.measures import GraspMeasure, length, measure, sensing_errors, true_contacts
from graspdsl.worlds.protocol import Observation, Truth

LEAK_WORTH_COUNTING = 1e-6
NEVER = -1  # in place of a tick
ROOM = 256  # ticks to begin with
Row = Mapping[str, Array | Flags | float]


class Logbook:
    """The running numbers of N trials that began together, (N,) each, and their trajectories where these are kept.

    Ticks count from 0, as the rows of a trajectory do; NEVER stands where there was none. ``first_touch``: the one at
    which every contact first touched; ``control_start``: at which the controller took over from the guarded close;
    ``held_since``: from which on the end conditions have held; ``last``: the latest one. ``shift`` [m] and ``lean``
    [rad] of the object; ``largest_leak`` and ``leaking_ticks`` of the priority certificate; ``world_s``: the world's
    time [s] at the last tick.
    """

    def __init__(self, grasps: Sequence[ContactSet], origins: Array, levels: int, *, trajectories: bool = True) -> None:
        """``grasps``: of the phases; origins: (N, 3), where the objects are [m] to begin with; ``levels``: the most
        leaks that a tick has to tell of."""
        count = len(origins)
        self._grasps, self._origins, self._levels, self._keeps = grasps, origins, levels, trajectories
        self._rows, self._exact = _Columns(count, np.float32), _Columns(count, np.float64)
        self._touch_phase, self._phase = np.zeros((2, count), dtype=np.intp)
        self.first_touch, self.control_start, self.held_since, self.last = np.full((4, count), NEVER, dtype=np.intp)
        self.world_s, self.shift, self.lean, self.largest_leak = np.zeros((4, count))
        self.leaking_ticks = np.zeros(count, dtype=np.intp)

    def write(self, tick: int, trials: Rows, phase: int, seen: Observation, truth: Truth, ticks: Ticks) -> GraspMeasure:
        """Write down a tick of M of the trials; what stood there is overwritten, as the next controller sees the same
        observation again. Returns the measures of their grasps."""
        grasp = self._grasps[phase]
        now = measure(seen, truth, grasp)
        touching = seen.touching[:, list(grasp.contacts)].all(axis=-1)
        first = trials[touching & (self.first_touch[trials] == NEVER)]
        self.first_touch[first], self._touch_phase[first] = tick, phase
        controlled = (self.first_touch[trials] != NEVER) & (self._touch_phase[trials] < phase)
        self.control_start[trials[controlled & (self.control_start[trials] == NEVER)]] = tick
        self.last[trials], self._phase[trials], self.world_s[trials] = tick, phase, seen.time
        self.shift[trials] = length(truth.object_position - self._origins[trials])
        self.lean[trials] = truth.object_lean
        leak = ticks.leaks.max(axis=-1, initial=0.0)
        self.largest_leak[trials] = np.fmax(self.largest_leak[trials], leak)
        self.leaking_ticks[trials] += leak > LEAK_WORTH_COUNTING
        if self._keeps:
            self._write_down(tick, trials, phase, seen, truth, ticks, now)
        return now

    def _write_down(
        self, tick: int, trials: Rows, phase: int, seen: Observation, truth: Truth, ticks: Ticks, now: GraspMeasure
    ) -> None:
        points, normals = true_contacts(seen, truth)
        felt, distance, sine, cosine = sensing_errors(seen, truth)
        measured: Row = {
            "force_residual": now.force_residual,
            "moment_residual": now.moment_residual,
            "orientation": now.orientation,
        }
        row: Row = {
            "time": seen.time,
            "phase": phase,
            **measured,
            "sensed_force_residual": ticks.force_residual,
            "sensed_moment_residual": ticks.moment_residual,
            "leaks": _padded(ticks.leaks, self._levels),
            "null_space_ranks": _padded(ticks.ranks, self._levels),
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
        }
        pressing = np.einsum("...ki,...ki->...k", np.nan_to_num(truth.forces), normals)
        self._rows.put(tick, trials, row)
        self._exact.put(
            tick,
            trials,
            {**measured, "pressing": pressing, "felt": felt, "distance": distance, "sine": sine, "cosine": cosine},
        )

    def trajectory(self, trial: int) -> Mapping[str, Float32Array]:
        """The arrays of a trial, one row a tick; none where it had no tick."""
        return self._rows.of(trial, int(self.last[trial]) + 1)

    def ticks_to_converge(self, trial: int) -> int | None:
        """Ticks or probes of the controller until the end conditions began to hold for good."""
        begun, held = self._begun(trial), int(self.held_since[trial])
        return None if NEVER in (begun, held) else max(0, held - begun)

    def numbers(self, trial: int) -> dict[str, Any]:
        """What the record of a trial takes from here, by the record's names.

        The start is the first tick at which every contact touched, else the first of all.
        """
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
            "largest_leak": float(self.largest_leak[trial]),
            "leaking_ticks": int(self.leaking_ticks[trial]),
            "point_error": _percentiles(exact["distance"][exact["felt"] > 0.0] if exact else np.zeros(0)),
            "normal_error": _percentiles(_angles(exact) if exact else np.zeros(0)),
            "samples": samples,
            "world_s": float(self.world_s[trial]),
        }

    def _begun(self, trial: int) -> int:
        """The tick at which the controller takes over from the close, or of the first touch where there is only one."""
        control = int(self.control_start[trial])
        return int(self.first_touch[trial]) if control == NEVER else control


class _Columns:
    """Arrays by name, (ticks, N, ...), that grow with the ticks."""

    def __init__(self, count: int, kind: type[np.floating[Any]]) -> None:
        self._count, self._kind = count, kind
        self._arrays: dict[str, Any] = {}

    def put(self, tick: int, trials: Rows, row: Row) -> None:
        for name, values in row.items():
            array = self._arrays.get(name)
            if array is None:
                array = np.zeros((ROOM, self._count, *np.shape(values)[1:]), dtype=self._kind)
            if tick >= len(array):
                array = np.concatenate([array, np.zeros_like(array)])
            array[tick, trials] = values
            self._arrays[name] = array

    def of(self, trial: int, ticks: int) -> dict[str, Any]:
        """The arrays of a trial, (ticks, ...), each on its own."""
        return {name: array[:ticks, trial].copy() for name, array in self._arrays.items()} if ticks else {}


def _padded(values: Array, width: int) -> Array:
    """The values (M, w) and then NaN, so that the rows of all phases are alike."""
    return np.concatenate([values, np.full((len(values), width - values.shape[-1]), np.nan)], axis=-1)


def _angles(exact: Mapping[str, Array]) -> Array:
    """The angles [rad] between sensed and true normals, of all that was felt.

    Tick by tick, for the arctangents of many numbers are rounded otherwise than those of few.
    """
    felt = exact["felt"] > 0.0
    each = zip(exact["sine"], exact["cosine"], felt, strict=True)
    return np.concatenate([np.arctan2(sine[known], cosine[known]) for sine, cosine, known in each])


def _percentiles(values: Array) -> tuple[float, float]:
    """Median and 95th percentile; NaN of nothing."""
    if len(values) == 0:
        return math.nan, math.nan
    half, most = np.percentile(values, [50, 95])
    return float(half), float(most)
