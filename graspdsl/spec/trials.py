"""How many trials there are, and how each one starts."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Collection, Mapping
from typing import Annotated, Literal

from pydantic import Field, ValidationError, model_validator

from graspdsl.places.fields import Count, Model, Number, Seconds, fault
from graspdsl.spec.distributions import Angle, Gap, Height, JointPlace, Length, Relative, outcomes_of
from graspdsl.spec.keeping import ALL, Keep

MOST_TRIALS = 100_000
PARAMETERS: Mapping[str, str] = {  # the numbers of a start, with their units
    "roll": "rad",
    "height": "m",
    "standoff": "m",
    "yaw": "rad",
    "offset": "m",
    "tilt": "rad",
}
FARTHEST = 10.0  # m or rad, wider than any bound of a start

End = Annotated[Number, Field(ge=-FARTHEST, le=FARTHEST)]


class StartSettings(Model):
    """Where the hand stands when a trial starts; every number may be a distribution."""

    approach: Literal["side", "top", "surface"] | None = Field(
        default=None,
        description="where the palm faces the object from, by default side, and surface in the floating world; side: "
        "from beside it; top: from above; surface: contacts drawn evenly over it, for the floating world",
    )
    roll: Angle = Field(default=0.0, description="rotation (rad) of the hand about the normal of its palm")
    height: Height = Field(
        default=0.10,
        description="height (m) of the palm above the table, or {relative: …}, a fraction of the object's height",
    )
    standoff: Gap = Field(default=0.047, description="gap (m) between palm and object")
    yaw: Angle = Field(default=0.0, description="direction (rad) the hand comes from, about the vertical")
    offset: Length = Field(default=0.0, description="sideways displacement (m) of the hand from the object's axis")
    tilt: Angle = Field(default=0.0, description="rotation (rad) of the palm's normal out of its plane of approach")
    posture: dict[str, JointPlace] = Field(
        default={}, description="joints (rad or m) of the hand that start elsewhere than in its open posture"
    )

    @property
    def is_fixed(self) -> bool:
        """Whether every draw is the same."""
        return self.outcomes() == 1

    def before(self, height: float) -> StartSettings:
        """The start with a height in m, before an object of a height [m]."""
        if not isinstance(self.height, Relative):
            return self
        return self.model_copy(update={"height": self.height.of(height)})

    def outcomes(self, given: Collection[str] = ()) -> float:
        """How many different starts can be drawn, inf for any number, where some parameters are given."""
        idle = {*given, *(("height",) if self.approach == "top" else ())}
        places = {name: getattr(self, name) for name in PARAMETERS if name not in idle}
        return math.prod(map(outcomes_of, (*places.values(), *self.posture.values())))


class GridAxis(Model):
    """One axis of a grid of starts: the number of a start that it stands for, at the middles of equal cells."""

    parameter: Literal["roll", "height", "standoff", "yaw", "offset", "tilt"] = Field(
        description="which number of 'start' is laid on the grid, in its unit", examples=["roll"]
    )
    low: End = Field(description="where the first cell begins, in the unit of the parameter", examples=[-1.5])
    high: End = Field(description="where the last cell ends, in the unit of the parameter", examples=[1.5])
    cells: Count = Field(ge=1, le=1000, description="how many cells there are, 1 to 1000", examples=[40])

    @model_validator(mode="after")
    def _a_range_of_starts(self) -> GridAxis:
        if self.low >= self.high:
            message = f"the low end {self.low:g} is not below the high end {self.high:g}"
            raise fault("out-of-range", message, "give the lower end first")
        try:
            StartSettings.model_validate({self.parameter: {"uniform": (self.low, self.high)}})
        except ValidationError as error:
            context = error.errors()[0].get("ctx", {})
            message = f"{self.parameter}: {context.get('message', 'these ends cannot be')}"
            raise fault("out-of-range", message, context.get("hint")) from None
        return self

    def middle(self, cell: int) -> float:
        """The value at the middle of a cell, counted from 0."""
        return self.low + (cell + 0.5) * (self.high - self.low) / self.cells


class Trials(Model):
    """The trials of a run."""

    count: Count = Field(default=20, ge=1, le=MOST_TRIALS, description="how many trials there are, 1 to 100000")
    seed: Count = Field(default=0, ge=0, le=2**63 - 1, description="what the random numbers are made from, 0 to 2⁶³−1")
    start: StartSettings = Field(default=StartSettings.usual(), description="where the hand stands when a trial starts")
    grid: tuple[GridAxis, ...] | None = Field(
        default=None,
        min_length=1,
        max_length=6,
        description="lays numbers of 'start' on a grid, a trial a cell, those of the first axis side by side; trials "
        "past the last cell begin at the first again",
    )

    keep: Keep = Field(
        default=ALL,
        description="which ticks of trajectories are kept: all; the first and the last, the ends; none; every=10 for "
        "every tenth and the last. What a trial measures does not depend on it",
        examples=["every=10"],
    )

    wall_limit: Seconds = Field(
        default=600.0,
        gt=0,
        le=1e6,
        description="how long (s) the computer may take for a trial before it is given up, where several processes "
        "share them",
    )

    @model_validator(mode="after")
    def _each_axis_once(self) -> Trials:
        counts = Counter(axis.parameter for axis in self.grid or ())
        twice = [parameter for parameter, count in counts.items() if count > 1]
        if twice:
            raise fault("declared-twice", f"the grid has two axes of {twice[0]}", "keep one of them")
        cells = math.prod(axis.cells for axis in self.grid or ())
        if cells > MOST_TRIALS:
            raise fault("out-of-range", f"a grid has at most {MOST_TRIALS} cells, this one {cells}", "use fewer cells")
        return self

    def before(self, height: float) -> Trials:
        """The trials with heights in m, before an object of a height [m]."""
        return self.model_copy(update={"start": self.start.before(height)})

    @property
    def different(self) -> float:
        """How many trials can differ by their starts, inf for any number."""
        axes = self.grid or ()
        return math.prod(axis.cells for axis in axes) * self.start.outcomes([axis.parameter for axis in axes])

    def start_of(self, number: int) -> StartSettings:
        """What the start of a trial is drawn from: on a grid, with the numbers of its cell in their places."""
        values: dict[str, float] = {}
        for axis in self.grid or ():
            number, cell = divmod(number, axis.cells)
            values[axis.parameter] = axis.middle(cell)
        return self.start.model_copy(update=values)
