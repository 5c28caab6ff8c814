"""What a trial writes down tick by tick, and the numbers its record takes from it."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from graspdsl.arrays import Array, Float32Array
from graspdsl.basis.resources import ContactSet
from graspdsl.compiler.pipeline import Tick
from graspdsl.trials.measures import GraspMeasure, measure, sensing_errors, true_contacts
from graspdsl.worlds.protocol import Observation, Truth

LEAK_WORTH_COUNTING = 1e-6


@dataclass(slots=True)
class Logbook:
    """The trajectory of one trial and its running numbers. ``levels``: the most leaks that a tick has to tell of;
    ``world_s``: the world's time [s] at the last tick."""

    origin: Array
    levels: int = 0
    rows: dict[str, list[Float32Array]] = field(default_factory=dict)
    measures: list[GraspMeasure] = field(default_factory=list)
    first_touch: int | None = None
    control_start: int | None = None
    held_since: int | None = None
    world_s: float = 0.0
    shift: float = 0.0
    lean: float = 0.0
    contact_forces: tuple[float, ...] = ()
    largest_leak: float = 0.0
    leaking_ticks: int = 0
    _touch_phase: int = 0
    _point_errors: list[Array] = field(default_factory=list)
    _normal_errors: list[Array] = field(default_factory=list)

    def write(self, phase: int, grasp: ContactSet, observation: Observation, truth: Truth, tick: Tick) -> GraspMeasure:
        """Write one tick down; returns the measure of the grasp."""
        if self.measures and observation.time == self.world_s:
            self._forget_last()  # the same observation again, seen by the next controller
        now = measure(observation, truth, grasp)
        points, normals = true_contacts(observation, truth)
        if self.first_touch is None and observation.touching[list(grasp.contacts)].all():
            self.first_touch, self._touch_phase = len(self.measures), phase
        if self.control_start is None and self.first_touch is not None and phase > self._touch_phase:
            self.control_start = len(self.measures)
        self.measures.append(now)
        self.world_s = observation.time
        self.shift = float(np.linalg.norm(truth.object_position - self.origin))
        self.lean = truth.object_lean
        forces = np.einsum("ki,ki->k", np.nan_to_num(truth.forces), normals)
        self.contact_forces = tuple(float(forces[contact]) for contact in grasp.contacts)
        leak = max(tick.leaks, default=0.0)
        self.largest_leak = max(self.largest_leak, leak)
        self.leaking_ticks += leak > LEAK_WORTH_COUNTING
        point_error, normal_error = sensing_errors(observation, truth)
        self._point_errors.append(point_error)
        self._normal_errors.append(normal_error)
        row = {
            "time": observation.time,
            "phase": phase,
            "force_residual": now.force_residual,
            "moment_residual": now.moment_residual,
            "orientation": now.orientation,
            "sensed_force_residual": tick.force_residual,
            "sensed_moment_residual": tick.moment_residual,
            "leaks": _padded(tick.leaks, self.levels),
            "null_space_ranks": _padded(tick.ranks, self.levels),
            "joints": observation.joints,
            "touching": observation.touching,
            "sensed_points": observation.points,
            "sensed_normals": observation.normals,
            "sensed_forces": observation.forces,
            "points": points,
            "normals": normals,
            "forces": truth.forces,
            "object_position": truth.object_position,
            "object_rotation": truth.object_rotation,
            "object_axis": truth.object_axis,
        }
        for name, value in row.items():
            self.rows.setdefault(name, []).append(np.asarray(value, dtype=np.float32))
        return now

    @property
    def start(self) -> GraspMeasure:
        """The measure at the first tick at which every contact touched, else at the first tick."""
        return self.measures[self.first_touch or 0] if self.measures else NOTHING

    @property
    def end(self) -> GraspMeasure:
        """The measure at the last tick."""
        return self.measures[-1] if self.measures else NOTHING

    @property
    def samples(self) -> int:
        """Tactile readings that the controller used."""
        begun = self._begun
        return 0 if begun is None else len(self.measures) - begun

    @property
    def ticks(self) -> int:
        """Ticks or probes of the controller to the end."""
        return max(0, self.samples - 1)

    @property
    def ticks_to_converge(self) -> int | None:
        """Ticks or probes of the controller until the end conditions began to hold for good."""
        begun = self._begun
        return None if begun is None or self.held_since is None else max(0, self.held_since - begun)

    @property
    def _begun(self) -> int | None:
        """The row at which the controller takes over from the close, or of the first touch where there is only one."""
        return self.first_touch if self.control_start is None else self.control_start

    def _forget_last(self) -> None:
        del self.measures[-1], self._point_errors[-1], self._normal_errors[-1]
        for rows in self.rows.values():
            del rows[-1]

    def point_error(self) -> tuple[float, float]:
        """Median and 95th percentile of the distance [m] of sensed from true contact points."""
        return _percentiles(self._point_errors)

    def normal_error(self) -> tuple[float, float]:
        """Median and 95th percentile of the angle [rad] between sensed and true normals."""
        return _percentiles(self._normal_errors)

    def trajectory(self) -> dict[str, Float32Array]:
        """The rows as arrays, one row a tick."""
        return {name: np.stack(rows) for name, rows in self.rows.items()}


def _padded(values: Sequence[float], length: int) -> list[float]:
    """The values and then NaN, so that the rows of all phases are alike."""
    return [*values, *[math.nan] * (length - len(values))]


NOTHING = GraspMeasure(math.nan, math.nan, math.nan)


def _percentiles(errors: list[Array]) -> tuple[float, float]:
    values = np.concatenate(errors) if errors else np.zeros(0)
    if len(values) == 0:
        return math.nan, math.nan
    half, most = np.percentile(values, [50, 95])
    return float(half), float(most)
