"""What the models have to keep whose fields are keys in a spec: descriptions, units, examples, a round trip."""

from __future__ import annotations

import json
import math
import re
from collections.abc import Iterator
from typing import Any

from pydantic import BaseModel, ValidationError
from pydantic.fields import FieldInfo

from graspdsl.contracts.rule import Breach

UNIT = re.compile(r"\((m|N|N·m|N/m|rad|kg|kg/m³|Hz|s|1)\)|\(m\) and|(?<=\()(s|m|N|rad)(?=\))")


def unsaid(thing: type, *texts: str) -> Iterator[Breach]:
    """A class says what it is: a docstring, and one line for lists under each of some names."""
    if not (thing.__doc__ or "").strip():
        yield "it has no docstring", "write what it is"
    for name in texts:
        text = getattr(thing, name, None)
        if not isinstance(text, str) or not text or "\n" in text or text.endswith("."):
            yield f"its {name} is {text!r}", f"write {name} in one line, without a full stop"


def undescribed(model: type[BaseModel]) -> Iterator[Breach]:
    """Each key has a description, that of a number with its unit in brackets; one that must be given has an example."""
    for name, field in model.model_fields.items():
        if not field.description:
            yield f"the key {name} has no description", "write Field(description=…)"
        elif _is_number(field) and not UNIT.search(field.description):
            yield f"the description of {name} names no unit", "write it in brackets: (m), (1) where it has none"
        if field.is_required() and not field.examples:
            yield f"the key {name} has no example", "write Field(examples=[…])"


def not_again(thing: BaseModel) -> Iterator[Breach]:
    """What is written out and read again is the same, and its JSON Schema can be made."""
    kind = type(thing)
    text = json.dumps(thing.model_dump(mode="json", by_alias=True))
    if kind.model_validate(json.loads(text)) != thing:
        yield f"{text} is read as something else", "let each field be what is given, without a change"
    if set(kind.model_json_schema()["properties"]) != {f.alias or name for name, f in kind.model_fields.items()}:
        yield "its JSON Schema has other keys than it has", "do not override the schema"


def too_lenient(thing: BaseModel) -> Iterator[Breach]:
    """Unknown keys and numbers that are none are refused, by the model itself."""
    kind, given = type(thing), thing.model_dump(by_alias=True)
    if _accepts(kind, {**given, "no_such_key": 1.0}):
        yield "it takes a key that it does not have", "derive it from the model of its kind, which forbids such keys"
    for name, field in kind.model_fields.items():
        if _is_number(field) and _accepts(kind, {**given, field.alias or name: math.nan}):
            yield f"it takes a {name} that is no number", "use the types of graspdsl.places.fields, such as Metres"


def _accepts(kind: type[BaseModel], given: dict[str, Any]) -> bool:
    try:
        kind.model_validate(given)
    except ValidationError:
        return False
    return True


def _is_number(field: FieldInfo) -> bool:
    return "float" in str(field.annotation) and "tuple" not in str(field.annotation)
