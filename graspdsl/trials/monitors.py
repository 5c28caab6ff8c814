"""Monitors: they watch the truth, as the chapter's human monitor did, and end a trial that went wrong."""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass, field

import numpy as np

from graspdsl.arrays import Array, Flags
from graspdsl.basis.resources import ContactSet
from graspdsl.spec.monitors import OFF, MonitorBounds
from graspdsl.trials.measures import GraspMeasure
from graspdsl.trials.outcomes import Outcome, Verdict
from graspdsl.worlds.protocol import Observation, Truth, WorldInfo

AT_LIMIT = 1e-3  # rad or m


@dataclass(slots=True)
class Monitors:
    """The monitors of one stage of a trial. ``palm``: the link that is the palm; ``radius`` [m] makes a length of a
    moment; ``samples``: how many make a window of progress; ``began``: (n,) joint positions when the trial began."""

    bounds: MonitorBounds
    grasp: ContactSet
    info: WorldInfo
    palm: str
    radius: float
    samples: int
    began: Array
    _since: dict[str, float] = field(default_factory=dict)
    _history: deque[float] = field(default_factory=deque)

    def watch(
        self,
        observation: Observation,
        truth: Truth,
        shift: float,
        *,
        locked: Flags | None = None,
        met: bool = False,
    ) -> Verdict | None:
        """What is wrong now, if anything is.

        shift [m]: how far the object has moved since the start; locked: (n,) joints that the controller keeps from
        going beyond their limits; met: whether the end conditions of the stage hold.
        """
        if not np.isfinite(truth.object_position).all() or not np.isfinite(observation.points).all():
            return Verdict(Outcome.CRASHED, "the simulation left the realm of numbers")
        verdict = self._touches(observation.time, truth)
        if verdict is not None:
            return verdict
        if _beyond(truth.object_lean, self.bounds.lean):
            return Verdict(Outcome.TOPPLED, f"the object leant {truth.object_lean:.2f} rad")
        if _beyond(shift, self.bounds.shift):
            return Verdict(Outcome.DIVERGED, f"the object was moved {1000 * shift:.0f} mm")
        stopped = np.isin(self.info.joints, truth.stopped_joints)
        return self._joints(observation, stopped if locked is None else stopped | locked, met)

    def _touches(self, time: float, truth: Truth) -> Verdict | None:
        """Links that touch what they should not."""
        bounds = self.bounds
        others = [link for link in truth.touching_links if link != self.palm]
        if self._lasts("palm", self.palm in truth.touching_links, time, bounds.palm):
            return Verdict(Outcome.PALM_COLLISION, "the palm touched the object" + _for(bounds.palm))
        if self._lasts("link", bool(others), time, bounds.link):
            return Verdict(Outcome.LINK_COLLISION, f"{', '.join(others)} touched the object" + _for(bounds.link))
        if self._lasts("table", bool(truth.table_links), time, bounds.table):
            links = ", ".join(truth.table_links)
            return Verdict(Outcome.TABLE_CONTACT, f"{links} touched the table" + _for(bounds.table))
        return None

    def _joints(self, observation: Observation, stopped: Flags, met: bool) -> Verdict | None:
        """Joints that are stopped at a limit and keep the stage from its end."""
        bound = self.bounds.joint_limit
        hindering = stopped & (np.abs(observation.joints - self.began) > AT_LIMIT) & (not met)
        pressing = [
            name
            for name, is_hindering in zip(self.info.joints, hindering, strict=True)
            if self._lasts(f"joint {name}", bool(is_hindering), observation.time, bound)
        ]
        return Verdict(Outcome.JOINT_LIMIT, f"{', '.join(pressing)} at a limit" + _for(bound)) if pressing else None

    def judge(self, shift: float) -> Verdict:
        """The verdict on a grasp whose end conditions have held: converged, unless the object was dragged there."""
        if _beyond(shift, self.bounds.dragged):
            return Verdict(Outcome.DRAGGED, f"a low residual, but the object was dragged {1000 * shift:.0f} mm")
        return Verdict(Outcome.CONVERGED)

    def watch_contacts(self, observation: Observation) -> Verdict | None:
        """A contact that has not touched for a while, once all did."""
        for contact in self.grasp.contacts:
            name = self.info.contacts[contact]
            if self._lasts(f"contact {name}", not observation.touching[contact], observation.time, self.bounds.lost):
                return Verdict(Outcome.CONTACT_LOST, f"{name} lost the object" + _for(self.bounds.lost))
        return None

    def has_stalled(self, measure: GraspMeasure) -> bool:
        """Whether the residual has stopped falling: its least value of a window is hardly below that of the one
        before."""
        progress = self.bounds.progress
        if progress == OFF:
            return False
        value = math.hypot(measure.force_residual, measure.moment_residual / self.radius)
        window = self.samples
        self._history.append(value)
        if len(self._history) < 2 * window:
            return False
        values = list(self._history)
        self._history.popleft()
        before, after = min(values[:window]), min(values[window:])
        return after > (1.0 - progress.least) * before

    def out_of_time(self, observation: Observation, limit: float, waited_for: str) -> Verdict:
        """What kept a phase from its end within its limit [s]: a contact never made, a joint at its limit, or just
        time, with what was waited for. What nobody watches for is no cause."""
        missing = [self.info.contacts[c] for c in self.grasp.contacts if not observation.touching[c]]
        if missing and self.bounds.lost != OFF:
            return Verdict(Outcome.CONTACT_LOST, f"{', '.join(missing)} made no contact within {limit:g} s")
        joints = observation.joints
        at_limit = (joints > self.info.upper - AT_LIMIT) | (joints < self.info.lower + AT_LIMIT)
        stuck = at_limit & (np.abs(joints - self.began) > AT_LIMIT)
        names = [name for name, is_stuck in zip(self.info.joints, stuck, strict=True) if is_stuck]
        if names and self.bounds.joint_limit != OFF:
            return Verdict(Outcome.JOINT_LIMIT, f"{', '.join(names)} at a limit")
        return Verdict(Outcome.TIMEOUT, f"not converged within {limit:g} s: {waited_for}")

    def _lasts(self, what: str, happens: bool, time: float, bound: float | str) -> bool:
        """Whether something goes on for longer than it may; a bound of zero means at once."""
        if not happens or isinstance(bound, str):
            self._since.pop(what, None)
            return False
        lasted = time - self._since.setdefault(what, time)
        return bound == 0.0 or lasted > bound


def window_of(bounds: MonitorBounds, info: WorldInfo, *, probes: bool) -> int:
    """How many samples make a window of progress: probes, or the ticks of its seconds; 0 when nobody watches."""
    if bounds.progress == OFF:
        return 0
    return bounds.progress.probes if probes else max(1, round(bounds.progress.window * info.rate))


def _beyond(value: float, bound: float | str) -> bool:
    return not isinstance(bound, str) and value > bound


def _for(bound: float | str) -> str:
    """How long something lasted that ended a trial, in words."""
    return f" for {bound:g} s" if bound else ""
