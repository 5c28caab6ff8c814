"""Building blocks of the models: numbers with units, and values that may be written in several forms."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Annotated, Any, ClassVar, Self

from pydantic import BaseModel, BeforeValidator, ConfigDict, Discriminator, Field, Tag, ValidationInfo
from pydantic_core import PydanticCustomError, PydanticKnownError

from graspdsl.places.wording import shown

FORM = "form:"  # how the tags of alternative forms begin; they are no part of a path in the file


class Model(BaseModel):
    """A frozen record of the spec that refuses unknown keys."""

    model_config = ConfigDict(frozen=True, extra="forbid", defer_build=True)

    meant_by: ClassVar[Mapping[str, str]] = {}  # the hint of an unknown key that says what a known one is about

    @classmethod
    def usual(cls) -> Self:
        """The record of which nothing is said; made without its validator, which takes its time to build."""
        return cls.model_construct()


@dataclass(frozen=True, slots=True)
class Unit:
    """The unit of a number, for messages."""

    symbol: str


Number = Annotated[float, Field(strict=True, allow_inf_nan=False)]
Count = Annotated[int, Field(strict=True)]
Metres = Annotated[Number, Unit("m")]
Seconds = Annotated[Number, Unit("s")]
Kilograms = Annotated[Number, Unit("kg")]


def name_in(table: str) -> BeforeValidator:
    """A text that is a name in a table of things; the context of a validation says, by table, which there are."""

    def check(value: Any, info: ValidationInfo) -> Any:
        known = (info.context or {}).get(table)
        if known is not None and not (isinstance(value, str) and value in known):
            raise PydanticKnownError("literal_error", {"expected": ", ".join(map(repr, known))})
        return value

    return BeforeValidator(check)


def fault(code: str, message: str, hint: str | None = None, write: str | None = None) -> PydanticCustomError:
    """A complaint of a validator; ``code`` becomes the code of the diagnostic, ``write`` its fix."""
    return PydanticCustomError(code, "{message}", {"message": message, "hint": hint, "write": write})


def forms(expected: str, choose: Callable[[Any], str | None]) -> Discriminator:
    """Tells alternative forms apart: ``choose`` names the form of a value, or None when it has none of them."""

    def tag(value: Any) -> str | None:
        name = choose(value)
        return None if name is None else FORM + name

    return Discriminator(tag, custom_error_type="wrong-form", custom_error_message=f"expected {expected}")


def form(name: str) -> Tag:
    """Marks one of the alternatives that :func:`forms` chooses from."""
    return Tag(FORM + name)


def is_number(value: object) -> bool:
    """Whether a value is a number; truth values are not."""
    return isinstance(value, int | float) and not isinstance(value, bool)


def exactly(count: int, expected: str) -> BeforeValidator:
    """Refuses what is not a list of ``count`` values, in one complaint."""

    def check(value: Any) -> Any:
        if not isinstance(value, list | tuple):
            raise fault("wrong-type", f"expected {expected}, found {shown(value)}")
        if len(value) != count:
            raise fault("wrong-length", f"expected {expected}, found {len(value)} values")
        return value

    return BeforeValidator(check)
