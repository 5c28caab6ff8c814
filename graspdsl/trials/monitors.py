"""Monitors: they watch the truth, as the chapter's human monitor did, and end a trial that went wrong."""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass, field

import numpy as np

from graspdsl.basis.resources import ContactSet
from graspdsl.trials.measures import GraspMeasure
from graspdsl.trials.outcomes import Outcome, Verdict
from graspdsl.worlds.protocol import Observation, Truth


@dataclass(frozen=True, slots=True)
class Bounds:
    """When a monitor speaks. Angles in rad, lengths in m, times in s."""

    lean: float = 0.35
    shift: float = 0.10
    lost: float = 2.0
    stalled: float = 6.0
    progress: float = 0.02


@dataclass(slots=True)
class Monitors:
    """The monitors of one stage of a trial. ``palm``: the link whose touch of the object ends it."""

    grasp: ContactSet
    contacts: tuple[str, ...]
    palm: str
    rate: float
    radius: float
    bounds: Bounds = field(default_factory=Bounds)
    _untouched: dict[int, int] = field(default_factory=dict)
    _history: deque[float] = field(default_factory=deque)

    def watch(self, observation: Observation, truth: Truth, shift: float) -> Verdict | None:
        """What is wrong now, if anything is; shift [m]: how far the object has moved since the start."""
        if self.palm in truth.touching_links:
            return Verdict(Outcome.PALM_COLLISION, "the palm touched the object")
        if not np.isfinite(truth.object_position).all() or not np.isfinite(observation.points).all():
            return Verdict(Outcome.CRASHED, "the simulation left the realm of numbers")
        if truth.object_lean > self.bounds.lean:
            return Verdict(Outcome.TOPPLED, f"the object leant {truth.object_lean:.2f} rad")
        if shift > self.bounds.shift:
            return Verdict(Outcome.DIVERGED, f"the object was moved {1000 * shift:.0f} mm")
        return None

    def watch_contacts(self, observation: Observation) -> Verdict | None:
        """A contact that has not touched for a while, once all did."""
        for contact in self.grasp.contacts:
            missed = 0 if observation.touching[contact] else self._untouched.get(contact, 0) + 1
            self._untouched[contact] = missed
            if missed > self.bounds.lost * self.rate:
                return Verdict(
                    Outcome.CONTACT_LOST, f"{self.contacts[contact]} lost the object for {self.bounds.lost:g} s"
                )
        return None

    def watch_progress(self, measure: GraspMeasure) -> Verdict | None:
        """A residual that has stopped falling: its least value of a time is hardly below that of the time before."""
        value = math.hypot(measure.force_residual, measure.moment_residual / self.radius)
        window = int(self.bounds.stalled * self.rate)
        self._history.append(value)
        if len(self._history) < 2 * window:
            return None
        values = list(self._history)
        self._history.popleft()
        before, after = min(values[:window]), min(values[window:])
        if after > (1.0 - self.bounds.progress) * before:
            return Verdict(
                Outcome.LOCAL_MINIMUM, f"the residual stopped falling at ‖ρ_f‖ = {measure.force_residual:.2f}"
            )
        return None
