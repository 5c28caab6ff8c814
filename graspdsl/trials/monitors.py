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
    """When a monitor speaks. Angles in rad, lengths in m, times in s.

    ``shift`` ends a trial at once; ``dragged`` is too much for a grasp to count as converged.
    """

    lean: float = 0.35
    shift: float = 0.10
    dragged: float = 0.02
    lost: float = 2.0
    progress: float = 0.02


@dataclass(slots=True)
class Monitors:
    """The monitors of one stage of a trial. ``palm``: the link whose touch of the object ends it; ``held``: the
    object is meant to move with the hand; ``samples``: how many without progress are a minimum."""

    grasp: ContactSet
    contacts: tuple[str, ...]
    palm: str
    radius: float
    samples: int
    held: bool = False
    bounds: Bounds = field(default_factory=Bounds)
    _lost_from: dict[int, float] = field(default_factory=dict)
    _history: deque[float] = field(default_factory=deque)

    def watch(self, observation: Observation, truth: Truth, shift: float) -> Verdict | None:
        """What is wrong now, if anything is; shift [m]: how far the object has moved since the start."""
        if self.palm in truth.touching_links:
            return Verdict(Outcome.PALM_COLLISION, "the palm touched the object")
        if not np.isfinite(truth.object_position).all() or not np.isfinite(observation.points).all():
            return Verdict(Outcome.CRASHED, "the simulation left the realm of numbers")
        if self.held:
            return None
        if truth.object_lean > self.bounds.lean:
            return Verdict(Outcome.TOPPLED, f"the object leant {truth.object_lean:.2f} rad")
        if shift > self.bounds.shift:
            return Verdict(Outcome.DIVERGED, f"the object was moved {1000 * shift:.0f} mm")
        return None

    def judge(self, shift: float) -> Verdict:
        """The verdict on a grasp whose end conditions have held: converged, unless the object was dragged there."""
        if not self.held and shift > self.bounds.dragged:
            return Verdict(Outcome.DIVERGED, f"a low residual, but the object was dragged {1000 * shift:.0f} mm")
        return Verdict(Outcome.CONVERGED)

    def watch_contacts(self, observation: Observation) -> Verdict | None:
        """A contact that has not touched for a while, once all did."""
        for contact in self.grasp.contacts:
            if observation.touching[contact]:
                self._lost_from.pop(contact, None)
                continue
            lost_from = self._lost_from.setdefault(contact, observation.time)
            if observation.time - lost_from > self.bounds.lost:
                return Verdict(
                    Outcome.CONTACT_LOST, f"{self.contacts[contact]} lost the object for {self.bounds.lost:g} s"
                )
        return None

    def watch_progress(self, measure: GraspMeasure) -> Verdict | None:
        """A residual that has stopped falling: its least value of a time is hardly below that of the time before."""
        value = math.hypot(measure.force_residual, measure.moment_residual / self.radius)
        window = self.samples
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
