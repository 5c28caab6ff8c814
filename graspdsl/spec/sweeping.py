"""Sweeps: a spec's trials at several points, which differ in the values of some of its fields."""

from __future__ import annotations

import json
import math
from collections.abc import Iterator, Mapping, Sequence
from itertools import product
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import AfterValidator, ConfigDict, Field, model_validator

from graspdsl.places.fields import Count, Model, Number, exactly, fault, form, forms
from graspdsl.places.wording import Data, shortened

MOST_POINTS = 1000
ALIKE = ("graspdsl", "name", "about", "code", "sweep")  # what all points have the same
OF_ALL = ("count", "seed", "keep", "wall_limit")  # of their trials, too
LARGEST = 1e9  # of any unit, wider than the bounds of a field
DIGITS = 6  # that numbers are rounded to which are not written one by one

End = Annotated[Number, Field(ge=-LARGEST, le=LARGEST)]
Point = Mapping[str, Data]  # the values of fields by their dotted paths


def _field(path: str) -> str:
    first, _, rest = path.partition(".")
    if not all(path.split(".")):
        raise fault("bad-override", f"expected the dotted path of a field, found {shortened(path)!r}", "scene.friction")
    if first in ALIKE or (first == "trials" and rest.partition(".")[0] in ("", *OF_ALL)):
        raise fault("same-at-all-points", f"{shortened(path)} is the same at all points of a sweep", "sweep another")
    return path


Path = Annotated[str, AfterValidator(_field)]


class Steps(Model):
    """Numbers from one to another, evenly spaced."""

    model_config = ConfigDict(serialize_by_alias=True)

    low: End = Field(alias="from", description="the first of the numbers, in the unit of the field")
    high: End = Field(alias="to", description="the last of them")
    count: Count = Field(alias="steps", ge=2, le=MOST_POINTS, description="how many numbers there are, 2 to 1000")
    scale: Literal["linear", "log"] = Field(
        default="linear", description="what is evenly spaced; linear: the numbers; log: their logarithms"
    )

    @model_validator(mode="after")
    def _apart(self) -> Steps:
        if self.low == self.high:
            raise fault("out-of-range", "the two ends are the same", "give two numbers")
        if self.scale == "log":
            _above_zero(min(self.low, self.high))
        return self

    def values(self) -> list[Data]:
        """The numbers."""
        space = np.geomspace if self.scale == "log" else np.linspace
        return list(map(_rounded, space(self.low, self.high, self.count)))


def _rounded(value: float) -> float:
    """A number that can be read, and typed again."""
    return float(f"{value:.{DIGITS}g}")


def _above_zero(low: float) -> None:
    if low <= 0.0:
        raise fault("out-of-range", f"a logarithm needs numbers above 0, found {low:g}", "begin above 0")


def _form_of_values(value: Any) -> str | None:
    if isinstance(value, Steps | dict):
        return "steps"
    return "list" if isinstance(value, list | tuple) else None


def _each_once(values: Sequence[Any]) -> Sequence[Any]:
    for place, value in enumerate(values):
        if any(_same(value, other) for other in values[:place]):
            raise fault("declared-twice", f"{shortened(_written(value))} stands here twice", "leave one out")
    return values


def _same(one: Data, other: Data) -> bool:
    return type(one) is type(other) and one == other


Values = Annotated[
    Annotated[tuple[Any, ...], Field(min_length=1), AfterValidator(_each_once), form("list")]
    | Annotated[Steps, form("steps")],
    forms("a list of values, or {from: 0.2, to: 1.0, steps: 5}", _form_of_values),
]


class Drawn(Model):
    """A value that is drawn for each point."""

    uniform: Annotated[tuple[End, End], exactly(2, "[low, high]: two numbers")] | None = Field(
        default=None, description="[low, high]: any number between them, each as likely as the others"
    )
    log_uniform: Annotated[tuple[End, End], exactly(2, "[low, high]: two numbers")] | None = Field(
        default=None, description="[low, high]: any number between them, each logarithm as likely as the others"
    )
    normal: Annotated[tuple[End, End], exactly(2, "[mean, sd]: two numbers")] | None = Field(
        default=None, description="[mean, standard deviation] of a normal distribution"
    )
    choice: tuple[Any, ...] | None = Field(default=None, min_length=1, description="one of these values")

    @model_validator(mode="after")
    def _one_that_can_be(self) -> Drawn:
        given = [name for name in type(self).model_fields if getattr(self, name) is not None]
        if len(given) != 1:
            message = "expected one of uniform, log_uniform, normal and choice"
            raise fault("wrong-form", message, "for example {uniform: [0.2, 1.0]}")
        for low, high in filter(None, (self.uniform, self.log_uniform)):
            if low > high:
                raise fault("out-of-range", f"the low end {low:g} is above the high end {high:g}", "turn them round")
        if self.log_uniform:
            _above_zero(self.log_uniform[0])
        if self.normal and self.normal[1] < 0.0:
            raise fault("out-of-range", f"the standard deviation {self.normal[1]:g} is below 0", "write [mean, sd]")
        return self

    def value(self, random: np.random.Generator) -> Data:
        """One of them."""
        if self.choice is not None:
            chosen: Data = self.choice[int(random.integers(len(self.choice)))]
            return chosen
        if self.normal is not None:
            return _rounded(random.normal(*self.normal))
        if self.log_uniform is not None:
            low, high = map(math.log, self.log_uniform)
            return _rounded(math.exp(random.uniform(low, high)))
        assert self.uniform is not None
        return _rounded(random.uniform(*self.uniform))


class RandomPoints(Model):
    """Points whose values are drawn, each field's by itself."""

    points: Count = Field(ge=1, le=MOST_POINTS, description="how many points there are, 1 to 1000", examples=[20])
    seed: Count = Field(default=0, ge=0, le=2**63 - 1, description="what they are drawn from, 0 to 2⁶³−1")
    over: dict[Path, Drawn] = Field(
        min_length=1,
        description="what each field is drawn from, by its dotted path",
        examples=[{"scene.friction": {"uniform": [0.3, 1.0]}}],
    )

    def drawn(self) -> Iterator[Point]:
        """The points."""
        random = np.random.default_rng(self.seed)
        for _ in range(self.points):
            yield {path: values.value(random) for path, values in self.over.items()}


class Sweep(Model):
    """What the trials of a spec are run at, one after the other: points that differ in some of its fields. All points
    have as many trials, from the same seed, so that trials of the same number begin alike wherever they can."""

    model_config = ConfigDict(serialize_by_alias=True)

    grid: dict[Path, Values] | None = Field(
        default=None,
        min_length=1,
        description="every combination of these values of fields, by their dotted paths; those of the last field side "
        "by side",
        examples=[{"scene.friction": [0.3, 0.6, 1.0], "control.step": {"from": 1e-4, "to": 1e-3, "steps": 4}}],
    )
    listed: tuple[dict[Path, Any], ...] | None = Field(
        default=None,
        alias="list",
        min_length=1,
        max_length=MOST_POINTS,
        description="the points one by one, each with the values of the same fields",
        examples=[[{"scene.friction": 0.3, "scene.mount": "gantry"}, {"scene.friction": 0.6, "scene.mount": "wam"}]],
    )
    random: RandomPoints | None = Field(default=None, description="points whose values are drawn")

    @model_validator(mode="after")
    def _one_kind_of_points(self) -> Sweep:
        if sum(kind is not None for kind in (self.grid, self.listed, self.random)) != 1:
            raise fault("wrong-form", "expected one of grid, list and random", "grid: {scene.friction: [0.3, 0.6]}")
        count = math.prod(map(len, map(_values, self.grid.values()))) if self.grid else 0
        if count > MOST_POINTS:
            raise fault(
                "out-of-range", f"a sweep has at most {MOST_POINTS} points, this one {count}", "use fewer values"
            )
        for place, point in enumerate(self.listed or ()):
            if not point or point.keys() != (self.listed or ())[0].keys():
                message = f"point {place} has not the fields of the first"
                raise fault("missing-key", message, "give every point a value of every field")
        return self

    @property
    def fields(self) -> tuple[str, ...]:
        """What the points differ in: the dotted paths of fields."""
        over = self.random.over if self.random else self.grid or (self.listed or ({},))[0]
        return tuple(over)

    def points(self) -> list[Point]:
        """The points, in the order in which they are run."""
        if self.listed is not None:
            return list(self.listed)
        if self.random is not None:
            return list(self.random.drawn())
        grid = {path: _values(values) for path, values in (self.grid or {}).items()}
        return [dict(zip(grid, values, strict=True)) for values in product(*grid.values())]


def _values(values: Steps | tuple[Any, ...]) -> Sequence[Data]:
    return values.values() if isinstance(values, Steps) else values


def setting(path: str, value: Data) -> str:
    """A value of a field as ``--set`` takes it."""
    return f"{path}={_written(value)}"


def settings(point: Point) -> tuple[str, ...]:
    """The values of a point as ``--set`` takes them."""
    return tuple(map(setting, point, point.values()))


def _written(value: Data) -> str:
    return json.dumps(value, ensure_ascii=False)
