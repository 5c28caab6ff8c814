"""A number that may differ from trial to trial: fixed, or drawn from a distribution."""

from __future__ import annotations

import math
from typing import Annotated, Any

from pydantic import AfterValidator, Field, model_validator

from graspdsl.places.fields import Model, Number, Unit, exactly, fault, form, forms, is_number
from graspdsl.places.wording import as_yaml


class Uniform(Model):
    """Any number between two ends, each as likely as the others."""

    uniform: Annotated[tuple[Number, Number], exactly(2, "[low, high]: two numbers")] = Field(
        description="[low, high], in the unit of the field"
    )

    @model_validator(mode="after")
    def _ordered(self) -> Uniform:
        low, high = self.uniform
        if low > high:
            message = f"the low end {as_yaml(low)} is above the high end {as_yaml(high)}"
            raise fault("out-of-range", message, f"write [{as_yaml(high)}, {as_yaml(low)}]")
        return self


class Normal(Model):
    """A normal distribution."""

    normal: Annotated[tuple[Number, Number], exactly(2, "[mean, sd]: two numbers")] = Field(
        description="[mean, standard deviation], in the unit of the field"
    )

    @model_validator(mode="after")
    def _spread(self) -> Normal:
        if self.normal[1] < 0:
            message = f"the standard deviation {as_yaml(self.normal[1])} is below 0"
            raise fault("out-of-range", message, "write [mean, sd]")
        return self


class Choice(Model):
    """One of some numbers, each as likely as the others."""

    choice: tuple[Number, ...] = Field(min_length=1, description="the numbers to choose from, in the unit of the field")


def _form_of(value: Any) -> str | None:
    if is_number(value):
        return "number"
    if isinstance(value, Uniform | Normal | Choice):
        return type(value).__name__.lower()
    if isinstance(value, dict):
        named = [name for name in ("uniform", "normal", "choice") if name in value]
        return named[0] if len(named) == 1 else None
    return None


EXPECTED = "a number, {uniform: [low, high]}, {normal: [mean, sd]} or {choice: [a, b, …]}"

Distribution = Annotated[
    Annotated[Number, form("number")]
    | Annotated[Uniform, form("uniform")]
    | Annotated[Normal, form("normal")]
    | Annotated[Choice, form("choice")],
    forms(EXPECTED, _form_of),
]


def numbers_of(value: float | Uniform | Normal | Choice) -> tuple[float, ...]:
    """The numbers of a distribution that must lie inside bounds: its ends, its mean or its choices."""
    if isinstance(value, Uniform):
        return value.uniform
    if isinstance(value, Normal):
        return value.normal[:1]
    return value.choice if isinstance(value, Choice) else (value,)


def outcomes_of(value: float | Uniform | Normal | Choice | Relative) -> float:
    """How many different numbers can be drawn: inf from a continuous distribution."""
    match value:
        case Relative(relative=fractions):
            return outcomes_of(fractions)
        case Uniform(uniform=(low, high)) if low < high:
            return math.inf
        case Normal(normal=(_, spread)) if spread > 0.0:
            return math.inf
        case Choice(choice=values):
            return len(set(values))
    return 1


def _between(low: float, high: float, unit: str, hint: str) -> AfterValidator:
    def check(value: float | Uniform | Normal | Choice | Relative) -> float | Uniform | Normal | Choice | Relative:
        if isinstance(value, Relative):  # which has had its own bounds
            return value
        for number in numbers_of(value):
            if not low <= number <= high:
                message = f"expected numbers from {low:g} to {high:g} ({unit}), found {as_yaml(number)}"
                raise fault("out-of-range", message, hint)
        widest = 0.5 * (high - low)
        if isinstance(value, Normal) and value.normal[1] > widest:
            found = as_yaml(value.normal[1])
            message = f"expected a standard deviation of at most {widest:g} ({unit}), found {found}"
            raise fault("out-of-range", message, hint)
        return value

    return AfterValidator(check)


_TURN = 2 * math.pi

Angle = Annotated[Distribution, Unit("rad"), _between(-_TURN, _TURN, "rad", "angles are in radians")]
JointPlace = Annotated[Distribution, _between(-_TURN, _TURN, "rad or m", "angles are in radians, lengths in metres")]
_METRES = _between(-2.0, 2.0, "m", "lengths are in metres")
Length = Annotated[Distribution, Unit("m"), _METRES]
Gap = Annotated[Distribution, Unit("m"), _between(0.0, 2.0, "m", "lengths are in metres")]
Fraction = Annotated[Distribution, Unit("1"), _between(-2.0, 2.0, "1", "0 is the table, 1 the top of the object")]


class Relative(Model):
    """A height over that of the object as it is put down."""

    relative: Fraction = Field(
        description="a fraction of the object's height (1), 0 at the table and 1 at its top; it may be a distribution",
        examples=[0.5],
    )

    def of(self, height: float) -> float | Uniform | Normal | Choice:
        """The heights [m] over an object of a height [m]."""
        match self.relative:
            case Uniform(uniform=(low, high)):
                return Uniform(uniform=(low * height, high * height))
            case Normal(normal=(mean, deviation)):
                return Normal(normal=(mean * height, deviation * height))
            case Choice(choice=values):
                return Choice(choice=tuple(value * height for value in values))
        assert isinstance(self.relative, float)
        return self.relative * height


def _form_of_height(value: Any) -> str | None:
    if isinstance(value, Relative):
        return "relative"
    if isinstance(value, dict) and "relative" in value:
        return "relative" if _form_of(value) is None else None
    return _form_of(value)


Height = Annotated[
    Annotated[Number, form("number")]
    | Annotated[Uniform, form("uniform")]
    | Annotated[Normal, form("normal")]
    | Annotated[Choice, form("choice")]
    | Annotated[Relative, form("relative")],
    forms(f"{EXPECTED}, or {{relative: …}} with one of them", _form_of_height),
    Unit("m"),
    _METRES,
]
