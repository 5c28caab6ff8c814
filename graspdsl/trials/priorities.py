"""The priority certificate: what the executed motion did to each level that others are subject to, against what that
level alone would have done, in the unit of what it senses.

Of a level with sensor y and Jacobian J, a tick tells, with what the next tick shows:

    J a         what the level alone would have changed: a is the command without the levels below it, with the same
                caps, locks and gates behind it
    J (u − a)   the predicted disturbance: u is the command that was given. In parts: by the lower levels, shortened as
                the whole is; by caps, which shorten the level more than they would have; by locked joints
    J (e − u)   what was not carried out as commanded: e is the measured motion, of joints for commands to joints and of
                contact points for commands to contacts. Joints lag, meet limits, and are held up
    Δy − J e    what J does not know: contacts lost or found in that tick, else soft ones, friction, the true surface
    Δy − J a    the observed disturbance: all of these

J is of all that the sensor senses, τ(Γσ), also of contacts that the level itself leaves alone.

A chain in a reference is one of contact displacements that joints carry out. Its u and e are what the joints do to the
contact points by their measured Jacobians: the motion of sensed points would mix in how contacts roll and are sensed.

Forces have a Jacobian for contacts of unit stiffness, so that the predicted disturbance of a force is told in metres of
pressing. How stiff a contact is no controller knows, and an admittance is no stiffness: what is observed, in newtons,
takes the stiffness [N/m] that was seen, the slope, by least squares over the ticks of a trial in which the level's
contacts touched throughout, of the sensed change on J e, and not below zero. No other explains more of what was sensed
by the hand's own motion, so that none leaves a smaller disturbance.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Annotated, Any

import numpy as np
from pydantic import Field

from graspdsl.arrays import Array, Flags, Rows
from graspdsl.basis.operations import by_contact, flat, times
from graspdsl.basis.resources import ContactSet
from graspdsl.compiler.graph import ControllerNode
from graspdsl.compiler.pipeline import Pipeline, Priority, Ticks
from graspdsl.trials.tick_rows import TickRows
from graspdsl.worlds.protocol import Observation

CAUSES = LOWER, CAP, LOCKED, NOT_CARRIED_OUT, TOUCH, UNKNOWN = (
    "lower priorities",
    "a cap",
    "locked joints",
    "motion that was not carried out as commanded",
    "a contact lost or found",
    "what its Jacobian does not know",
)


@dataclass(frozen=True, slots=True)
class Largest:
    """The largest disturbance of a trial: its ``size``, the ``tick`` that commanded it, its ``time`` [s], and of all
    causes the one with the largest share."""

    size: Annotated[float, Field(ge=0, allow_inf_nan=False)]
    tick: Annotated[int, Field(ge=0)]
    time: Annotated[float, Field(ge=0, allow_inf_nan=False)]
    cause: str


@dataclass(frozen=True, slots=True)
class Disturbance:
    """What became of a level in a trial: its ``stage``, its name, the least ``rank`` of the null space below it, its
    largest disturbances, ``predicted`` and ``observed`` in the units of its priority, and the ``stiffness`` [N/m] that
    was seen where it needs one.
    """

    stage: Annotated[int, Field(ge=0)]
    level: str
    rank: Annotated[int, Field(ge=0)]
    predicted: Largest
    observed: Largest
    stiffness: Annotated[float, Field(ge=0, allow_inf_nan=False)] | None = None


def level_names(priorities: Sequence[Priority]) -> list[str]:
    """What the levels of a stage are called: by their potential, or in full where there are two of it."""
    symbols = [one.controller.potential.symbol for one in priorities]
    return [
        one.controller.label if symbols.count(symbol) > 1 else symbol
        for one, symbol in zip(priorities, symbols, strict=True)
    ]


class PriorityLog:
    """What becomes of the priorities of N trials side by side. What becomes of a tick is known with the next one."""

    def __init__(self, pipelines: Sequence[Pipeline], count: int, ticks: int = 1) -> None:
        """``pipelines``: by the numbers of their stages; ``ticks``: how many a trial may have."""
        self._pipelines, self._count = pipelines, count
        self.levels = max((len(pipeline.priorities) for pipeline in pipelines), default=0)
        self._stage, self._tick = np.full((2, count), -1, dtype=np.intp)
        self._noted: dict[int, dict[str, Any]] = {}
        self._latest: tuple[tuple[int, int], list[_Course]] | None = None  # asked for last
        self._told = {
            stage: TickRows(count, ticks, np.float64) for stage, pipeline in enumerate(pipelines) if pipeline.priorities
        }

    def begin(self, trials: Rows) -> None:
        """Other trials begin at these places."""
        for told in self._told.values():
            told.clear(trials, int(self._tick[trials].max()) + 1)
        self._stage[trials], self._tick[trials], self._latest = -1, -1, None

    def note(self, tick: Rows, trials: Rows, stage: int, seen: Observation, ticks: Ticks) -> None:
        """What a stage makes of T ticks in a row, the first (M,) of which are given, of M of the trials, (T, M, ...),
        and what has become of what it made of the one before each."""
        self._latest = None
        pipeline, count = self._pipelines[stage], len(seen.points)
        followed = (self._stage[trials] == stage) & (self._tick[trials] == tick - 1)
        self._stage[trials], self._tick[trials] = stage, tick + count - 1
        if not pipeline.priorities:
            return
        now = {name: getattr(ticks, name) for name in ("sensed", "effects", "own", "parts", "ranks")}
        now |= {"place": seen.joints if pipeline.space == "q" else flat(seen.points), "touching": seen.touching}
        if stage not in self._noted:
            room = {name: np.zeros((self._count, *value.shape[2:]), value.dtype) for name, value in now.items()}
            self._noted[stage] = room
        noted, told = self._noted[stage], self._told[stage]
        if followed.any():
            before = {name: values[trials[followed]][None] for name, values in noted.items()}
            after = {name: now[name][:1, followed] for name in _SEEN}
            told.put(tick[followed] - 1, trials[followed], _told(pipeline.priorities, before, after))
        if count > 1:
            before = {name: values[:-1] for name, values in now.items()}
            after = {name: now[name][1:] for name in _SEEN}
            told.put(tick, trials, _told(pipeline.priorities, before, after))
        for name, values in now.items():
            noted[name][trials] = values[-1]

    def channels(self, trial: int, ticks: int) -> dict[str, Array]:
        """The channels of a trial's trajectory, (ticks, L, …); NaN where its stage has less priorities, and where no
        next tick shows what became of one."""
        channels = {
            "predicted_disturbance": np.full((ticks, self.levels), math.nan),
            "observed_disturbance": np.full((ticks, self.levels), math.nan),
            "disturbance_by_cause": np.full((ticks, self.levels, len(CAUSES)), math.nan),
        }
        for one in self._courses(trial, ticks):
            at = one.ticks, one.place
            channels["predicted_disturbance"][at] = one.predicted
            channels["observed_disturbance"][at] = one.observed
            channels["disturbance_by_cause"][at] = one.by_cause
        return channels

    def disturbances(self, trial: int, time: Array) -> tuple[Disturbance, ...]:
        """What became of each level in a trial; ``time`` [s]: (ticks,), of its ticks."""
        return tuple(one.summed_up(time) for one in self._courses(trial, len(time)))

    def _courses(self, trial: int, ticks: int) -> Sequence[_Course]:
        """Each level whose disturbance was seen at any tick."""
        if self._latest is None or self._latest[0] != (trial, ticks):
            self._latest = (trial, ticks), list(self._found(trial, ticks))
        return self._latest[1]

    def _found(self, trial: int, ticks: int) -> Iterator[_Course]:
        for stage, told in self._told.items():
            rows, priorities = told.of(trial, ticks), self._pipelines[stage].priorities
            for place, (priority, name) in enumerate(zip(priorities, level_names(priorities), strict=True)):
                if not rows:
                    continue
                finite = [np.isfinite(rows[key][:, place]).all(axis=-1) for key in ("own", "carried", "change")]
                known = np.flatnonzero((rows["told"] > 0.0) & np.logical_and.reduce(finite))
                if len(known):
                    of_level = {key: values[known, place] for key, values in rows.items() if key != "told"}
                    yield _Course(stage, place, name, priority.controller, known, of_level)


_SEEN = ("sensed", "place", "touching")  # what of a tick tells what became of the one before


def _told(priorities: Sequence[Priority], before: Mapping[str, Any], after: Mapping[str, Any]) -> dict[str, Array]:
    """What has become of the priorities of M trials in T ticks, (T, M, L, …), and that it is known, (T, M)."""
    moved = after["place"] - before["place"]
    places = range(len(priorities))
    changes = [
        _change(priorities[place].controller, after["sensed"][..., place, :], before["sensed"][..., place, :])
        for place in places
    ]
    touched = [_kept_touch(one.controller, before["touching"], after["touching"]) for one in priorities]
    steady, pressed = (np.stack(kinds, axis=-1) for kinds in zip(*touched, strict=True))
    return {
        "told": np.ones(moved.shape[:-1]),
        "rank": before["ranks"],
        "own": before["own"],
        "parts": before["parts"],
        "carried": times(before["effects"], moved[..., None, :]),
        "change": np.stack(changes, axis=-2),
        "steady": steady,
        "pressed": pressed,
    }


def _change(controller: ControllerNode, after: Array, before: Array) -> Array:
    """How far what a controller senses has gone, (..., W)."""
    difference = controller.potential.difference
    if not difference.turns:
        return after - before
    rows = after.shape[-1] // 3 * 3  # what is padded does not turn
    turned = flat(difference.between(by_contact(after[..., :rows]), by_contact(before[..., :rows])))
    return np.concatenate([turned, np.zeros_like(after[..., rows:])], axis=-1)


def _kept_touch(controller: ControllerNode, before: Flags, after: Flags) -> tuple[Flags, Flags]:
    """Whether none of a controller's contacts was lost or found, and whether all touched throughout, (...) each."""
    resources = controller.sensor_resources
    contacts = list(resources.contacts) if isinstance(resources, ContactSet) else []
    before, after = before[..., contacts], after[..., contacts]
    return np.all(before == after, axis=-1), np.all(before & after, axis=-1)


@dataclass(frozen=True)
class _Course:
    """What became of a level in the ``ticks`` (t,) of a trial; ``place``: of the level among its stage's."""

    stage: int
    place: int
    name: str
    controller: ControllerNode
    ticks: Rows
    rows: Mapping[str, Array]

    @cached_property
    def stiffness(self) -> float | None:
        """The slope [N/m] of what was sensed on what the hand's motion pressed; None for a level that needs none."""
        if not self.controller.effector.pressed:
            return None
        pressed = self.rows["pressed"] > 0.0
        change, carried = self.rows["change"][pressed], self.rows["carried"][pressed]
        squared = float(np.sum(carried * carried))
        return max(0.0, float(np.sum(change * carried)) / squared) if squared > 0.0 else 0.0

    @cached_property
    def _parts(self) -> tuple[Array, Array]:
        """What each cause changed, (t, causes, W), and the disturbance that they make together, (t, W)."""
        stiffness = self.stiffness
        scale, rows = 1.0 if stiffness is None else stiffness, self.rows
        own, carried, parts = (scale * rows[name] for name in ("own", "carried", "parts"))
        beyond = rows["change"] - carried
        steady = (rows["steady"] > 0.0)[:, None]
        rest = [carried - own - parts.sum(axis=-2), np.where(steady, 0.0, beyond), np.where(steady, beyond, 0.0)]
        return np.concatenate([parts, np.stack(rest, axis=-2)], axis=-2), rows["change"] - own

    @property
    def predicted(self) -> Array:
        """How large the predicted disturbance is, (t,)."""
        return np.asarray(np.linalg.norm(self.rows["parts"].sum(axis=-2), axis=-1))

    @property
    def observed(self) -> Array:
        """How large the observed disturbance is, (t,)."""
        return np.asarray(np.linalg.norm(self._parts[1], axis=-1))

    @cached_property
    def by_cause(self) -> Array:
        """The shares of all causes in the observed disturbance, (t, causes); they sum to how large it is."""
        return _shares(*self._parts)

    def summed_up(self, time: Array) -> Disturbance:
        """The largest disturbances, and when."""
        commanded = self.rows["parts"]

        def largest(shares: Array) -> Largest:
            sizes = shares.sum(axis=-1)
            at = int(np.argmax(sizes))
            tick = int(self.ticks[at])
            return Largest(float(sizes[at]), tick, float(time[tick]), CAUSES[int(np.argmax(shares[at]))])

        return Disturbance(
            self.stage,
            self.name,
            int(self.rows["rank"].min()),
            largest(_shares(commanded, commanded.sum(axis=-2))),
            largest(self.by_cause),
            self.stiffness,
        )


def _shares(parts: Array, whole: Array) -> Array:
    """How far parts (t, c, W) go along the whole (t, W) that they sum to, (t, c); nothing of nothing."""
    size = np.linalg.norm(whole, axis=-1)[:, None]
    return np.asarray(np.einsum("tcw,tw->tc", parts, whole) / np.where(size > 0.0, size, 1.0))
