"""Records as rows of a table, and back: a row is believed only where every value can be one of a trial."""

from __future__ import annotations

import dataclasses
import json
import math
from collections.abc import Iterator, Mapping, Sequence
from functools import cache
from typing import Any, get_type_hints

from pydantic import BaseModel, ConfigDict, Field, ValidationError, create_model
from pydantic_core import from_json

from graspdsl.quality.grade import Grade
from graspdsl.quality.grades import GRADES
from graspdsl.trials.outcomes import OUTCOMES
from graspdsl.trials.priorities import Disturbance
from graspdsl.trials.record import LARGEST_VALUE, Balance, RejectedStart, TrialRecord

COLUMNS = tuple(field.name for field in dataclasses.fields(TrialRecord))
_MAPPINGS = ("start", "quality")
_PARTS = ("rejected", "priorities", "balance")
_ANGLES = ("orientation_start", "orientation_end")
_TUPLES = ("contact_forces", "point_error", "normal_error", "touching")
_TEXTS = (*_MAPPINGS, *_PARTS, *_TUPLES)  # columns of JSON
_SORTED = bytes.maketrans(b"0123456789E", b"0000000000e")
_LARGE = b"e00", b"e+00", b"0" * 30  # which numbers beyond LARGEST_VALUE have, once sorted
_MEASURED = tuple(name for name, kind in TrialRecord.__annotations__.items() if kind == "float")


class _Part(BaseModel):
    model_config = ConfigDict(strict=True)


class _Metric(_Part):
    value: float | None
    reason: str


def _read_of(grade: Grade) -> Any:
    """The model of what reports read of a grade."""
    fields: dict[str, Any] = {grade.passed: (bool, ...), "reason": (str, ...)} if grade.passed else {}
    fields |= {quantity.key: (_Metric, ...) for quantity in grade.quantities}
    return create_model("_Grade", __base__=_Part, **fields)


class _Parts(_Part):
    rejected: tuple[RejectedStart, ...]
    priorities: tuple[Disturbance, ...]
    balance: Balance | None


@cache
def _values(grades: tuple[Grade, ...]) -> type[BaseModel]:
    """The model of a row's values, with what the grades say."""
    of_grades: dict[str, Any] = {
        grade.key: (_read_of(grade), Field(default=None, alias=grade.name)) for grade in grades
    }
    quality = create_model("_Grades", __base__=_Part, **of_grades)
    kinds = {**get_type_hints(TrialRecord, include_extras=True), "outcome": str, "quality": quality}
    fields: dict[str, Any] = {name: (kind, ...) for name, kind in kinds.items()}
    return create_model("_Values", __base__=_Part, **fields)


def row_of(record: TrialRecord) -> list[object]:
    """A record as the values of COLUMNS, of types that SQLite keeps: NaN as NULL, mappings and tuples as JSON."""
    values = record.as_dict()
    return [_stored(values[name]) for name in COLUMNS]


def record_of(row: Sequence[Any]) -> TrialRecord:
    """The record that a row holds. Raises ValueError for values that no trial has."""
    values = dict(zip(COLUMNS, row, strict=True))
    try:
        large = _may_be_large(values)
        values |= {name: _tuple(values[name]) for name in _TUPLES}
        values |= {name: from_json(values[name], allow_inf_nan=False) for name in _MAPPINGS}
        parts = ", ".join(f'"{name}": {values[name] or "null"}' for name in _PARTS)
        values |= vars(_Parts.model_validate_json(f"{{{parts}}}"))
        values |= {name: math.nan for name in _MEASURED if values[name] is None}
        if values["outcome"] not in OUTCOMES:
            raise ValueError(f"{values['outcome']!r} is not a valid Outcome")
        values["outcome"] = OUTCOMES[values["outcome"]]
        _values(tuple(GRADES.values())).model_validate(values)
    except TypeError:
        raise ValueError("a value has another type") from None
    except ValidationError as error:
        first = error.errors(include_url=False, include_input=False)[0]
        raise ValueError(": ".join(filter(None, (".".join(map(str, first["loc"])), first["msg"].lower())))) from None
    if large and any(LARGEST_VALUE < abs(value) < math.inf for value in _numbers_in(values)):
        raise ValueError("a value is too large to be measured")
    if any(not (math.isnan(angle) or 0.0 <= angle <= math.pi / 2) for angle in (values[name] for name in _ANGLES)):
        raise ValueError("an orientation is not between 0 and π/2")
    if large and any(abs(value) == math.inf for value in _numbers_in(values["quality"])):
        raise ValueError("a grade is infinite")
    return TrialRecord(**values)


def _may_be_large(values: Mapping[str, Any]) -> bool:
    """Whether there can be a number beyond LARGEST_VALUE in a row, found without reading its texts number by number.
    Whole numbers of SQLite have 64 bits, which are less."""
    texts = " ".join([value for value in map(values.__getitem__, _TEXTS) if isinstance(value, str)])
    written = texts.encode().translate(_SORTED)
    floats = [value for value in values.values() if isinstance(value, float)]
    most = max(max(floats, default=0.0), -min(floats, default=0.0))
    return most > LARGEST_VALUE or any(large in written for large in _LARGE)


def _stored(value: object) -> object:
    if isinstance(value, dict | tuple):
        return json.dumps(value)
    return None if isinstance(value, float) and math.isnan(value) else value


def _tuple(text: Any) -> tuple[Any, ...]:
    value = from_json(text)
    if not isinstance(value, list):
        raise TypeError
    return tuple(value)


def _numbers_in(value: object) -> Iterator[float]:
    if isinstance(value, int | float):
        yield value
    elif isinstance(value, Mapping):
        for part in value.values():
            yield from _numbers_in(part)
    elif isinstance(value, tuple | list):
        for part in value:
            yield from _numbers_in(part)
    elif isinstance(value, RejectedStart):
        yield from value.drawn.values()
    elif isinstance(value, Balance):
        yield from _numbers_in(dataclasses.astuple(value))
