"""Monitors: what ends a trial that went wrong, and what a good grasp must not have done. Every line has a default.

They watch the truth, as the chapter's human monitor did.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from typing import Annotated, Any, ClassVar, TypeVar

import numpy as np
from pydantic import BaseModel, Field, create_model, model_validator
from pydantic.fields import FieldInfo

from graspdsl.arrays import Array, Flags, Rows
from graspdsl.places.fields import Count, Model, Number, Seconds, form, forms
from graspdsl.spec.growing import Growing, grow
from graspdsl.spec.outcomes import DOTS, LEVEL, Outcome
from graspdsl.spec.watching import (
    AT_ONCE,
    OFF,
    Angle,
    Beyond,
    Distance,
    Lasting,
    Monitor,
    Off,
    SceneFacts,
    Setting,
    Sight,
    TouchMonitor,
    When,
)

AT_LIMIT = 1e-3  # rad or m


class PalmMonitor(TouchMonitor):
    """The palm on the object."""

    key, touched = "palm", "object"
    description = "the palm touches the object, for this time (s): palm-collision"
    default = AT_ONCE
    outcome = Outcome("palm-collision", "the palm touched the object", "#5a636d")
    needs = ("hand",)
    of_a_free_object = True

    def who(self, sight: Sight, place: int) -> Sequence[str]:
        """The palm."""
        return ["the palm"] if self.setting.palm in sight.links[place] else []


class LinkMonitor(TouchMonitor):
    """Other links on the object."""

    key, touched = "link", "object"
    description = "any link but a fingertip and the palm touches the object, for this time (s): link-collision"
    default = 0.5
    outcome = Outcome("link-collision", "a link other than fingertips and palm touched the object", "#5a636d", LEVEL)
    needs = ("hand",)
    of_a_free_object = True

    def who(self, sight: Sight, place: int) -> Sequence[str]:
        """All but fingertips and the palm."""
        return [link for link in sight.links[place] if link != self.setting.palm]


class TableMonitor(TouchMonitor):
    """Links on the table."""

    key, touched = "table", "table"
    description = "any link of hand or arm touches the table, for this time (s): table-contact"
    default = AT_ONCE
    outcome = Outcome("table-contact", "a link touched the table", "#8f98a2", LEVEL)
    needs = ("hand", "table")

    def who(self, sight: Sight, place: int) -> Sequence[str]:
        """All that do."""
        return sight.table_links[place]


class LostMonitor(Lasting):
    """Contacts that part from the object, once all have touched."""

    key = "lost"
    description = "a contact does not touch any more, for this time (s): contact-lost"
    default = 2.0
    outcome = Outcome("contact-lost", "a contact was never made, or was lost", "#8f98a2")
    needs = ("parting",)
    turn = 2

    @staticmethod
    def width(setting: Setting) -> int:
        """One a contact."""
        return len(setting.contacts)

    def happens(self, sight: Sight) -> Flags:
        """Contacts of the grasp that do not touch, (M, k)."""
        grasped = np.zeros(sight.touching.shape[-1], dtype=bool)
        grasped[list(sight.grasp)] = True
        away: Flags = ~sight.touching & grasped & sight.touched[:, None]
        return away

    def detail(self, sight: Sight, place: int) -> str:
        """The first of those lost."""
        lost = next(contact for contact in sight.grasp if self.lasting[place, contact])
        return f"{self.setting.contacts[lost]} lost the object" + self.lasted

    def out_of_time(self, sight: Sight, place: int) -> str | None:
        """Contacts that were not made."""
        missing = [self.setting.contacts[c] for c in sight.grasp if not sight.touching[place, c]]
        return f"{', '.join(missing)} made no contact within {sight.limit:g} s" if missing else None


class JointLimitMonitor(Lasting):
    """Joints that are stopped at a limit and keep the stage from its end."""

    key = "joint_limit"
    description = (
        "a joint is told to go beyond its limit, for this time (s), while the phase has not reached its end: "
        "joint-limit; a joint at the limit where it began does not count"
    )
    default = 2.0
    outcome = Outcome("joint-limit", "a joint was kept from going on by its limit", "#8f98a2", DOTS)
    needs = ("hand",)
    turn = 1

    @staticmethod
    def width(setting: Setting) -> int:
        """One a joint."""
        return len(setting.joints)

    def happens(self, sight: Sight) -> Flags:
        """Joints in the way, (M, n)."""
        if not sight.stopped.any():
            return sight.stopped
        hindering: Flags = sight.stopped & self._moved(sight) & ~sight.met[:, None]
        return hindering

    def detail(self, sight: Sight, place: int) -> str:
        """Which joints, and for how long."""
        del sight
        return f"{self._names(self.lasting[place])} at a limit" + self.lasted

    def out_of_time(self, sight: Sight, place: int) -> str | None:
        """Joints that are at a limit now."""
        joints, setting = sight.joints[place], self.setting
        at_limit = (joints > setting.upper - AT_LIMIT) | (joints < setting.lower + AT_LIMIT)
        names = self._names(at_limit & self._moved(sight)[place])
        return f"{names} at a limit" if names else None

    def _names(self, chosen: Flags) -> str:
        return ", ".join(name for name, is_chosen in zip(self.setting.joints, chosen, strict=True) if is_chosen)

    def _moved(self, sight: Sight) -> Flags:
        """Joints that are not where they began, (M, n)."""
        moved: Flags = np.abs(sight.joints - self.setting.began[sight.rows]) > AT_LIMIT
        return moved


class LeanMonitor(Beyond):
    """An object that falls over."""

    key = "lean"
    description = "the object leans by more than this (rad): toppled"
    bound_type, default = Angle, 0.35
    outcome = Outcome.TOPPLED
    needs = ("motion", "upright")
    of_a_free_object = of_the_truth = True
    quantity, said = "lean", "the object leant {:.2f} rad"


class ShiftMonitor(Beyond):
    """An object that is moved away."""

    key = "shift"
    description = "the object has moved by more than this (m), at any time: diverged"
    bound_type, default = Distance, 0.10
    outcome = Outcome("diverged", "the object was moved away", "#23292f")
    needs = ("motion",)
    of_a_free_object = of_the_truth = True
    quantity, said, scale = "shift", "the object was moved {:.0f} mm", 1000.0


class DraggedMonitor(Beyond):
    """A grasp that has dragged the object along to where its residual is low."""

    key = "dragged"
    description = "the object has moved by more than this (m) in a grasp at its end: dragged"
    bound_type, default = Distance, 0.02
    outcome = Outcome(
        "dragged", "the end conditions held, but the object had been dragged", "#c9ced4", LEVEL, settled=True
    )
    needs = ("motion",)
    of_a_free_object = of_the_truth = True
    when = When.END
    quantity, said, scale = "shift", "a low residual, but the object was dragged {:.0f} mm", 1000.0

    @classmethod
    def out_of_reach(cls, bound: Any, scene: SceneFacts) -> str | None:
        """A trial whose object moves that far has ended before."""
        shift = scene.bounds["shift"]
        if OFF in (bound, shift) or bound < shift:
            return None
        return f"an object that has moved by {shift:g} m has ended the trial as diverged"


class Progress(Model):
    """When a residual counts as stuck: its least value of one window is hardly below that of the window before."""

    window: Seconds = Field(
        default=6.0, ge=0.1, le=600.0, description="length (s) of a window while contacts slide or float"
    )
    probes: Count = Field(default=15, ge=2, le=10_000, description="length of a window in probes (1)")
    least: Number = Field(
        default=0.02, gt=0.0, lt=1.0, description="share (1) of the residual that a window must take off it"
    )


def _progress_form(value: Any) -> str | None:
    if isinstance(value, dict | Progress):
        return "progress"
    return "off" if value == OFF else None


class ProgressMonitor(Monitor):
    """A residual that has stopped falling: its least value of a window is hardly below that of the one before."""

    key = "progress"
    description = "a residual that is waited for does not fall any more: local-minimum"
    bound_type = Annotated[
        Annotated[Progress, form("progress")] | Off,
        forms("{window: 6.0, probes: 15, least: 0.02}, on (the default) or off", _progress_form),
    ]
    default = Progress.usual()
    outcome = Outcome(
        "local-minimum",
        "the residual stopped falling before the end conditions held, as the hand senses them",
        "#c9ced4",
        settled=True,
    )
    when = When.STAYING

    def __init__(self, bound: Progress, setting: Setting) -> None:
        super().__init__(bound, setting)
        self._window = bound.probes if setting.probes else max(1, round(bound.window * setting.rate))
        # Values come in blocks of a window, so that the least of the last window is that of two parts: what there is of
        # this block, and the end of the one before. Likewise of the window before, a block back.
        count = len(setting.began)
        self._seen, self._least = np.zeros(count, dtype=np.intp), np.zeros(count)
        self._values, self._begins = np.zeros((2, self._window, count))
        self._ends, self._older_ends = np.full((2, self._window + 1, count), np.inf)

    def speaks(self, sight: Sight) -> Flags:
        """Residuals that have stalled; one that is low enough need not fall any more."""
        if not sight.awaits_residual:
            return np.zeros(len(sight.rows), dtype=bool)
        moments = sight.moment_residual / self.setting.curvature_radius
        stalled: Flags = self._stalled(sight.rows, np.hypot(sight.force_residual, moments)) & ~sight.met
        return stalled

    def _stalled(self, rows: Rows, lengths: Array) -> Flags:
        """Whether the least of the last window is hardly below that of the one before, (M,), with the next lengths."""
        place = self._seen[rows] % self._window
        least = np.where(place == 0, lengths, np.minimum(self._least[rows], lengths))
        self._values[place, rows], self._least[rows] = lengths, least
        self._seen[rows] += 1
        stalled: Flags = self._seen[rows] >= 2 * self._window
        if stalled.any():
            after = np.minimum(least, self._ends[place + 1, rows])
            before = np.minimum(self._begins[place, rows], self._older_ends[place + 1, rows])
            stalled &= after > (1.0 - self.bound.least) * before
        self._end_block(rows[place == self._window - 1])
        return stalled

    def _end_block(self, rows: Rows) -> None:
        """The least values from the beginning of a block, and to its end, of trials that have one."""
        if len(rows):
            values = self._values[:, rows]
            self._older_ends[:, rows] = self._ends[:, rows]
            self._begins[:, rows] = np.minimum.accumulate(values)
            self._ends[:-1, rows] = np.minimum.accumulate(values[::-1])[::-1]

    def detail(self, sight: Sight, place: int) -> str:
        """What is waited for."""
        return f"the residual stopped falling: {sight.waited_for(place)}"

    def begin_anew(self, rows: Rows) -> None:
        """Two windows are needed again."""
        self._seen[rows] = 0

    @classmethod
    def out_of_reach(cls, bound: Any, scene: SceneFacts) -> str | None:
        """Some phase must wait for a residual, for two windows."""
        if not scene.waiting:
            return "no phase waits for a residual"
        if bound == OFF or scene.tick is None or 2.0 * bound.window <= max(scene.waiting) + scene.tick:
            return None
        return f"no phase that waits for a residual lasts for two windows of {bound.window:g} s"


MONITORS: dict[str, type[Monitor]] = {
    monitor.key: monitor
    for monitor in (
        PalmMonitor,
        LinkMonitor,
        TableMonitor,
        LostMonitor,
        JointLimitMonitor,
        LeanMonitor,
        ShiftMonitor,
        DraggedMonitor,
        ProgressMonitor,
    )
}
OUTCOMES: dict[str, Outcome] = {
    outcome.value: outcome
    for outcome in (
        Outcome.CONVERGED,
        *dict.fromkeys(monitor.outcome for monitor in MONITORS.values()),
        Outcome.TIMEOUT,
        Outcome.UNDONE,
        Outcome.INFEASIBLE_START,
        Outcome.CRASHED,
    )
}

Lines = TypeVar("Lines", bound=Model)


def _line(monitor: type[Monitor], default: Any) -> Any:
    return Field(default=default, description=monitor.description)


def _with_lines(table: Mapping[str, type[Monitor]]) -> Callable[[type[Lines]], type[Lines]]:
    """Gives a model the lines of a table."""
    fields: dict[str, Any] = {key: (kind.bound_type, _line(kind, kind.default)) for key, kind in table.items()}

    def fill(model: type[Lines]) -> type[Lines]:
        return create_model(
            model.__name__, __base__=model, __doc__=model.__doc__, __module__=model.__module__, **fields
        )

    return fill


def _meant(monitor: type[Monitor], word: str | bool) -> Any:
    words: dict[str | bool, Any] = {True: monitor.default, "on": monitor.default, False: OFF, **monitor.words}
    return words.get(word, word)


@_with_lines(MONITORS)
class MonitorBounds(Growing):
    """The monitors. A time is how long something may last: 0, or stop, ends the trial at once; off never does."""

    later: ClassVar = set()
    silent: ClassVar = OFF

    meant_by: ClassVar[dict[str, str]] = {}

    @model_validator(mode="before")
    @classmethod
    def _words(cls, data: Any) -> Any:
        """Truth values and words for what they stand for."""
        if not isinstance(data, dict):
            return data
        return {
            key: _meant(MONITORS[key], value) if key in MONITORS and isinstance(value, str | bool) else value
            for key, value in data.items()
        }

    def in_effect(self, *, held: bool) -> MonitorBounds:
        """The monitors as they act on an object that is held, or is not."""
        idle = [key for key, monitor in MONITORS.items() if held and monitor.of_a_free_object]
        return self.model_copy(update={key: OFF for key in idle if key not in self.model_fields_set})

    def watches(self, setting: Setting, lacks: Collection[str] = ()) -> list[Monitor]:
        """The monitors that are not off, over N trials, but for those that need what a world lacks."""
        bounds = {key: self.given(key) for key, kind in MONITORS.items() if not set(kind.needs).intersection(lacks)}
        return [MONITORS[key](bound, setting) for key, bound in bounds.items() if bound != OFF]


def _tell_meaning(monitor: type[Monitor]) -> None:
    name = monitor.outcome.value
    if name != monitor.key:
        MonitorBounds.meant_by[name] = f"the monitor of {name} is {monitor.key}"


for _monitor in MONITORS.values():
    _tell_meaning(_monitor)


def add_monitor(monitor: type[Monitor], around: Sequence[type[BaseModel]]) -> None:
    """Enter a monitor into the table, its line into the models, the inner first, that are ``around`` the bounds.

    It is off unless a spec names it, so that the trials of no other spec depend on it.
    """
    field = FieldInfo.from_annotated_attribute(monitor.bound_type, _line(monitor, OFF))
    grow({(MonitorBounds, monitor.key): field}, around)
    MonitorBounds.later.add(monitor.key)
    MONITORS[monitor.key] = monitor
    OUTCOMES[monitor.outcome.value] = monitor.outcome
    _tell_meaning(monitor)
