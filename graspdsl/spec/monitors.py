"""Monitors: what ends a trial that went wrong, and what a good grasp must not have done. Every line has a default."""

from __future__ import annotations

from typing import Annotated, Any, ClassVar, Literal

from pydantic import Field, WithJsonSchema, model_validator

from graspdsl.places.fields import Count, Metres, Model, Number, Seconds, Unit, form, forms, is_number

OFF: Literal["off"] = "off"
AT_ONCE = 0.0  # s

Off = Annotated[Literal["off"], form("off"), WithJsonSchema({"enum": ["on", "off", True, False]})]
StopOrOff = Annotated[Literal["off"], form("off"), WithJsonSchema({"enum": ["on", "off", "stop", True, False]})]


class Progress(Model):
    """When a residual counts as stuck: its least value of one window is hardly below that of the window before."""

    window: Seconds = Field(
        default=6.0, ge=0.1, le=600.0, description="length (s) of a window while contacts slide or float"
    )
    probes: Count = Field(default=15, ge=2, le=10_000, description="length of a window in probes (1)")
    least: Number = Field(
        default=0.02, gt=0.0, lt=1.0, description="share (1) of the residual that a window must take off it"
    )


def _bound_form(value: Any) -> str | None:
    if is_number(value):
        return "number"
    return "off" if value == OFF else None


def _progress_form(value: Any) -> str | None:
    if isinstance(value, dict | Progress):
        return "progress"
    return "off" if value == OFF else None


Patience = Annotated[
    Annotated[Seconds, Field(ge=0.0, le=600.0), form("number")] | StopOrOff,
    forms("a number, stop (at once), on (the default) or off", _bound_form),
]
Angle = Annotated[
    Annotated[Number, Unit("rad"), Field(gt=0.0, le=3.1416), form("number")] | Off,
    forms("a number, on (the default) or off", _bound_form),
]
Distance = Annotated[
    Annotated[Metres, Field(gt=0.0, le=10.0), form("number")] | Off,
    forms("a number, on (the default) or off", _bound_form),
]
Window = Annotated[
    Annotated[Progress, form("progress")] | Off,
    forms("{window: 6.0, probes: 15, least: 0.02}, on (the default) or off", _progress_form),
]
TIMES = ("palm", "link", "table", "lost", "joint_limit")
OUTCOMES = {
    "palm-collision": "palm",
    "link-collision": "link",
    "table-contact": "table",
    "contact-lost": "lost",
    "joint-limit": "joint_limit",
    "toppled": "lean",
    "diverged": "shift",
    "local-minimum": "progress",
}
OF_A_FREE_OBJECT = ("palm", "link", "lean", "shift", "dragged")


class MonitorBounds(Model):
    """The monitors. A time is how long something may last: 0, or stop, ends the trial at once; off never does."""

    meant_by: ClassVar = {outcome: f"the monitor of {outcome} is {name}" for outcome, name in OUTCOMES.items()}

    palm: Patience = Field(
        default=AT_ONCE, description="the palm touches the object, for this time (s): palm-collision"
    )
    link: Patience = Field(
        default=0.5,
        description="any link but a fingertip and the palm touches the object, for this time (s): link-collision",
    )
    table: Patience = Field(
        default=AT_ONCE, description="any link of hand or arm touches the table, for this time (s): table-contact"
    )
    lost: Patience = Field(
        default=2.0, description="a contact does not touch any more, for this time (s): contact-lost"
    )
    joint_limit: Patience = Field(
        default=2.0,
        description="a joint is told to go beyond its limit, for this time (s), while the phase has not reached its "
        "end: joint-limit; a joint at the limit where it began does not count",
    )
    lean: Angle = Field(default=0.35, description="the object leans by more than this (rad): toppled")
    shift: Distance = Field(
        default=0.10, description="the object has moved by more than this (m), at any time: diverged"
    )
    dragged: Distance = Field(
        default=0.02, description="the object has moved by more than this (m) in a grasp at its end: dragged"
    )
    progress: Window = Field(
        default=Progress(), description="a residual that is waited for does not fall any more: local-minimum"
    )

    @model_validator(mode="before")
    @classmethod
    def _words(cls, data: Any) -> Any:
        """Truth values and words for what they stand for; stop is a time of zero."""
        if not isinstance(data, dict):
            return data
        meant = {
            name: {True: field.default, "on": field.default, False: OFF} for name, field in cls.model_fields.items()
        }
        for name in TIMES:
            meant[name]["stop"] = AT_ONCE
        return {
            key: meant[key].get(value, value) if key in meant and isinstance(value, str | bool) else value
            for key, value in data.items()
        }

    def in_effect(self, *, held: bool) -> MonitorBounds:
        """The monitors as they act. An object that is held is meant to touch the hand, to move and to lean: what
        watches for that is off unless the spec asks for it."""
        if not held:
            return self
        idle = [name for name in OF_A_FREE_OBJECT if name not in self.model_fields_set]
        return self.model_copy(update=dict.fromkeys(idle, OFF))
