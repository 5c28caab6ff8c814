"""The record of one trial: what began it, how it ended, what was measured."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Annotated, Any

from pydantic import Field, FiniteFloat

from graspdsl.arrays import Float32Array
from graspdsl.spec.keeping import ALL
from graspdsl.trials.outcomes import Outcome
from graspdsl.trials.priorities import Disturbance
from graspdsl.trials.trajectories import packed

LARGEST_VALUE = 1e30  # of any SI unit: above what a simulation that blew up measures, below where squares overflow

# Bounds for records that are read back; those that a trial makes keep them by themselves.
Count = Annotated[int, Field(ge=0)]
Load = tuple[FiniteFloat, FiniteFloat, FiniteFloat, FiniteFloat, FiniteFloat, FiniteFloat]
Duration = Annotated[float, Field(ge=0, allow_inf_nan=False)]


@dataclass(frozen=True, slots=True)
class RejectedStart:
    """A start that was drawn and that the world could not take up: its numbers [m or rad] and why."""

    drawn: Mapping[str, FiniteFloat]
    reason: str


@dataclass(frozen=True, slots=True)
class Balance:
    """What each party puts on the object in a final grasp: its force [N] along x, y and z and its moment [N·m] about
    the centre of mass, means over the last second, or over the time for which the end conditions have held if that is
    shorter. Together they are what is left over to accelerate the object, or what it is fixed to bears."""

    contacts: Load
    links: Load
    table: Load
    gravity: Load


@dataclass(frozen=True, slots=True)
class TrialRecord:
    """One trial. Lengths in m, angles in rad, forces in N, times in s; NaN where there was nothing to measure.

    ``start`` is what was drawn, ``rejected`` what was drawn before it and could not be taken up. *_start is measured at
    the first tick at which every contact touches (the first tick of all where that never came), *_end at the last tick.
    ``ticks`` counts from where the controller takes over from the guarded close to the end, ``ticks_to_converge`` to
    the tick from which on the end conditions held (None without convergence); where contacts are displaced by probing,
    a tick is a probe. ``samples`` counts the tactile readings that the controller used: one a tick, or one a probe.
    ``wall_s`` is the computer's time, an equal share of what was done for several trials at once. ``tare_s`` is that
    taken to tare the sensors, which ``world_s`` does not include. ``priorities``: what became of each level that others
    are subject to. ``balance`` is that of the final grasp, None where the world does not tell what acts on its object.
    ``quality`` holds the grades of the final grasp that the spec asks for, by their names. ``touching``: which of the
    contacts of the grasp touched at the last tick, by the simulator's truth and not as the hand senses it, in the order
    of ``contact_forces``; of none where there was no tick.
    """

    number: Count
    identity: str
    outcome: Outcome
    detail: str
    start: Mapping[str, FiniteFloat]
    rejected: tuple[RejectedStart, ...]
    orientation_start: float
    orientation_end: float
    force_residual_start: float
    force_residual_end: float
    moment_residual_start: float
    moment_residual_end: float
    contact_forces: tuple[float, ...]
    object_shift: float
    object_lean: float
    ticks: Count
    ticks_to_converge: Count | None
    samples: Count
    point_error: tuple[float, float]
    normal_error: tuple[float, float]
    world_s: Duration
    wall_s: float
    tare_s: float = 0.0
    priorities: tuple[Disturbance, ...] = ()
    balance: Balance | None = None
    quality: Mapping[str, Mapping[str, Any]] = field(default_factory=dict)
    touching: tuple[bool, ...] = ()

    @property
    def in_contact(self) -> bool | None:
        """Whether every contact of the grasp truly touched at the end; None where that is not known."""
        return all(self.touching) if self.touching else None

    @property
    def has_begun(self) -> bool:
        """Whether there was a start, and an object that stood, to begin with."""
        fell = self.outcome is Outcome.TOPPLED and self.samples == 0 and not self.contact_forces
        return not (self.outcome is Outcome.INFEASIBLE_START or fell)

    def as_dict(self) -> dict[str, object]:
        """Plain data, for the store."""
        return {**dataclasses.asdict(self), "outcome": self.outcome.value, "start": dict(self.start)}


@dataclass(frozen=True, slots=True)
class Trial:
    """A record with its trajectory: arrays by name, one row a tick."""

    record: TrialRecord
    trajectory: Mapping[str, Float32Array]

    def packed(self, keep: str = ALL) -> PackedTrial:
        """The same as it is kept."""
        return PackedTrial(self.record, packed(self.trajectory, keep))


@dataclass(frozen=True, slots=True)
class PackedTrial:
    """A record with its trajectory as a pack holds it."""

    record: TrialRecord
    trajectory: bytes
