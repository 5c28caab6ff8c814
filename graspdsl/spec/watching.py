"""What a monitor is: a line of the spec, and a watch over many trials that ends those that went wrong."""

from __future__ import annotations

import enum
from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Annotated, Any, ClassVar, Literal

import numpy as np
from pydantic import Field, WithJsonSchema

from graspdsl.arrays import Array, Flags, Rows
from graspdsl.places.fields import Metres, Number, Seconds, Unit, form, forms, is_number
from graspdsl.spec.outcomes import Outcome

OFF: Literal["off"] = "off"
AT_ONCE = 0.0  # s
# What monitors take in place of a number, and what it means.
SAID = {"on": "as by default", "off": "never", "stop": "at once"}

Off = Annotated[Literal["off"], form("off"), WithJsonSchema({"enum": ["on", "off", True, False]})]
StopOrOff = Annotated[Literal["off"], form("off"), WithJsonSchema({"enum": ["on", "off", "stop", True, False]})]


def _bound_form(value: Any) -> str | None:
    if is_number(value):
        return "number"
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


@dataclass(frozen=True, slots=True)
class Setting:
    """What monitors know of N trials from their beginning on.

    ``palm``: the link that is the palm; lower, upper: (n,) limits of the joints [m or rad]; began: (N, n) where they
    were, of each trial that has begun. ``curvature_radius`` [m] makes a length of a moment. ``probes``: whether a tick
    is a probe; rate: ticks a second.
    """

    contacts: tuple[str, ...]
    joints: tuple[str, ...]
    palm: str
    lower: Array
    upper: Array
    began: Array
    curvature_radius: float
    probes: bool
    rate: float


@dataclass(frozen=True, slots=True)
class Sight:
    """What monitors see of M trials at one tick of a stage; ``rows`` (M,) are their places among the N.

    time: (M,) [s]; ``grasp``: the contacts that the stage is about. touching: (M, k) and ``touched``: (M,), whether all
    of the grasp have touched in this stage, or had to before it. joints: (M, n) positions [m or rad]; stopped: (M, n),
    those that are kept from going beyond a limit. links, table_links: for each trial, what presses on the object
    without being a fingertip, and what presses on the table. lean [rad] and shift [m] of the object since the start:
    (M,). force_residual (1), moment_residual [m]: (M,) norms of what they are in truth. met: (M,), whether the end
    conditions hold. ``awaits_residual``: whether they bound a residual. ``limit`` [s] of the phase. ``waited_for``
    says what keeps the trial at a place of the M from its end.
    """

    rows: Rows
    time: Array
    grasp: tuple[int, ...]
    touching: Flags
    touched: Flags
    joints: Array
    stopped: Flags
    links: Sequence[Sequence[str]]
    table_links: Sequence[Sequence[str]]
    lean: Array
    shift: Array
    force_residual: Array
    moment_residual: Array
    met: Flags
    awaits_residual: bool
    limit: float
    waited_for: Callable[[int], str]


# Links; a table within reach; an object that can move, and one that can lean; contacts that can part from it.
Need = Literal["hand", "table", "motion", "upright", "parting"]


@dataclass(frozen=True, slots=True)
class SceneFacts:
    """What of a spec decides whether its monitors have anything to watch.

    ``lacks``: what there is not to watch, each with the reason. ``longest``: the longest limit [s] of a phase;
    ``waiting``: those of phases that wait for a residual; ``tick`` [s], None where a tick is a probe. ``bounds`` of all
    monitors by key.
    """

    lacks: Mapping[str, str]
    longest: float
    waiting: tuple[float, ...]
    tick: float | None
    bounds: Mapping[str, Any]


class When(enum.Enum):
    """When a monitor speaks: at any tick; at a tick at which the trial stays in its stage; at the end of the program,
    whose end conditions all held."""

    TICK = enum.auto()
    STAYING = enum.auto()
    END = enum.auto()


class Monitor(ABC):
    """A line under ``monitors:`` and, made for N trials with the bound that a spec gives it, the watch over them.

    ``bound_type`` and ``default``: of the line; ``words``: what may be written in place of a value, besides on and off.
    ``needs``: what a scene must have, or the monitor is idle. One ``of_a_free_object`` is off for a held object unless
    the spec asks for it: that is meant to touch the hand, to move and to lean. One ``of_the_truth`` watches what a hand
    does not sense: links that touch, and how the object moves and leans. Where several speak at the same tick,
    the one of the least ``turn`` is heard, then the first in the table.
    """

    key: ClassVar[str]
    description: ClassVar[str]
    outcome: ClassVar[Outcome]
    bound_type: ClassVar[Any]
    default: ClassVar[Any]
    words: ClassVar[Mapping[str | bool, Any]] = {}
    needs: ClassVar[tuple[Need, ...]] = ()
    of_a_free_object: ClassVar[bool] = False
    of_the_truth: ClassVar[bool] = False
    when: ClassVar[When] = When.TICK
    turn: ClassVar[int] = 0

    def __init__(self, bound: Any, setting: Setting) -> None:
        self.bound, self.setting = bound, setting

    @abstractmethod
    def speaks(self, sight: Sight) -> Flags:
        """Which of the M trials it ends, (M,)."""

    @abstractmethod
    def detail(self, sight: Sight, place: int) -> str:
        """What it says of the trial at a place of the M that it ends."""

    def begin_anew(self, rows: Rows) -> None:
        """These trials begin, or begin another stage: what was seen at their places is forgotten."""
        del rows

    def out_of_time(self, sight: Sight, place: int) -> str | None:
        """What it says of a trial whose time is up, where it knows what kept it from its end."""
        del sight, place
        return None

    @classmethod
    def out_of_reach(cls, bound: Any, scene: SceneFacts) -> str | None:
        """Why no trial of a scene can reach the bound; None where one may."""
        del bound, scene
        return None


class Lasting(Monitor):
    """A monitor of things that may go on for a time: 0 ends the trial at once."""

    bound_type = Patience
    words: ClassVar[Mapping[str | bool, Any]] = {"stop": AT_ONCE}

    def __init__(self, bound: float, setting: Setting) -> None:
        super().__init__(bound, setting)
        self._since = np.full((len(setting.began), self.width(setting)), np.nan)
        self._is_on = False  # whether anything happened at the last tick of any trial
        self.lasting: Flags = np.zeros((0, 0), dtype=bool)

    @staticmethod
    def width(setting: Setting) -> int:
        """How many things w there are to watch in a trial."""
        del setting
        return 1

    @abstractmethod
    def happens(self, sight: Sight) -> Flags:
        """What happens now, (M, w)."""

    def speaks(self, sight: Sight) -> Flags:
        """Trials in which something has gone on for longer than it may; ``lasting`` (M, w) says what."""
        happens = self.happens(sight)
        if not (self._is_on or happens.any()):
            self.lasting = happens
            return np.zeros(len(happens), dtype=bool)
        since, now = self._since[sight.rows], sight.time[:, None]
        since = np.where(happens, np.where(np.isnan(since), now, since), np.nan)
        self._since[sight.rows] = since
        self._is_on = not np.isnan(self._since).all()
        if self.bound != AT_ONCE:
            happens = np.asarray(happens & (now - since > self.bound))
        self.lasting = happens
        return np.asarray(self.lasting.any(axis=-1))

    def begin_anew(self, rows: Rows) -> None:
        """All times run anew."""
        self._since[rows] = np.nan

    @property
    def lasted(self) -> str:
        """How long it lasted, in words."""
        return f" for {self.bound:g} s" if self.bound else ""

    @classmethod
    def out_of_reach(cls, bound: Any, scene: SceneFacts) -> str | None:
        """Nothing lasts for longer than a phase."""
        return f"no phase lasts for more than {scene.longest:g} s" if bound >= scene.longest else None


class TouchMonitor(Lasting):
    """Links that press on what they should not."""

    touched: ClassVar[str]
    of_the_truth = True

    @abstractmethod
    def who(self, sight: Sight, place: int) -> Sequence[str]:
        """Which of them do, in the trial at a place of the M."""

    def happens(self, sight: Sight) -> Flags:
        """Some do, (M, 1)."""
        return np.array([[bool(self.who(sight, place))] for place in range(len(sight.rows))])

    def detail(self, sight: Sight, place: int) -> str:
        """Which, and for how long."""
        return f"{', '.join(self.who(sight, place))} touched the {self.touched}" + self.lasted


class Beyond(Monitor):
    """A quantity of the sight, by its name, that may grow to a bound; ``said`` tells it, times ``scale``."""

    quantity: ClassVar[str]
    said: ClassVar[str]
    scale: ClassVar[float] = 1.0

    def speaks(self, sight: Sight) -> Flags:
        """It is larger."""
        return np.asarray(getattr(sight, self.quantity) > self.bound)

    def detail(self, sight: Sight, place: int) -> str:
        """How large it is."""
        return self.said.format(self.scale * getattr(sight, self.quantity)[place])
