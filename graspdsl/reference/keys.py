"""Every key of a spec: its type, unit, default and the values that it may have by name, from the models themselves."""

from __future__ import annotations

import json
import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

from graspdsl.compiler.program import known_names
from graspdsl.spec.loading import json_schema
from graspdsl.spec.watching import SAID
from graspdsl.units import UNITS

Schema = Mapping[str, Any]

NEEDED = "needed"
BELOW = "as below"
_UNITS = {*(unit for unit, _ in UNITS.values()), "m/s²", "rad or m"}
_UNIT = re.compile(rf"\(({'|'.join(sorted(map(re.escape, _UNITS), key=len, reverse=True))})\)")
_TYPES = {"number": "number", "integer": "whole number", "string": "text", "boolean": "true or false", "array": "list"}


@dataclass(frozen=True, slots=True)
class Key:
    """A key: its type in words, the unit of its number, its default as YAML has it or why it has none, what it is, and
    the values that it may have by name, with a line each."""

    name: str
    type: str
    unit: str
    default: str
    about: str
    values: Mapping[str, str]


@dataclass(frozen=True, slots=True)
class Part:
    """A part of a spec: its place in the file, empty for the whole, what it is, and its keys."""

    place: str
    about: str
    keys: tuple[Key, ...]


def parts() -> tuple[Part, ...]:
    """The spec itself and each part that it refers to, in the order of first mention."""
    whole = json_schema(known_names())
    lines = {key: _text(field) for part in whole["$defs"].values() for key, field in part.get("properties", {}).items()}
    made = [_part("", whole, lines)]
    seen = set[str]()
    waiting = list(_below(whole, ""))
    while waiting:
        place, name = waiting.pop(0)
        if name not in seen:
            seen.add(name)
            part = whole["$defs"][name]
            made.append(_part(place, part, lines))
            waiting = [*_below(part, place), *waiting]
    return tuple(made)


def _below(schema: Schema, place: str) -> Iterator[tuple[str, str]]:
    """The parts that a schema's properties refer to: the place of each and its name."""
    for key, field in schema.get("properties", {}).items():
        for name in _references(field):
            yield f"{place}.{key}".lstrip("."), name


def _references(field: Any) -> Iterator[str]:
    for inner in _inside(field):
        if "$ref" in inner:
            yield str(inner["$ref"]).rpartition("/")[2]


def _inside(field: Any) -> Iterator[Schema]:
    """A field's schema and those within it."""
    if isinstance(field, Mapping):
        yield field
        for key, inner in field.items():
            if key not in ("default", "examples"):
                yield from _inside(inner)
    elif isinstance(field, list):
        for inner in field:
            yield from _inside(inner)


def _part(place: str, schema: Schema, lines: Mapping[str, str]) -> Part:
    required = schema.get("required", [])
    keys = (_key(name, field, name in required, lines) for name, field in schema.get("properties", {}).items())
    return Part(place, _text(schema), tuple(keys))


def _key(name: str, field: Schema, required: bool, lines: Mapping[str, str]) -> Key:
    about, said = _split(_text(field), list(_named(field)))
    # What no line says here is the name of a key, or one of the words that all monitors take.
    values = {value: said.get(value) or SAID.get(value) or lines.get(value, "") for value in _named(field)}
    unit = _UNIT.search(about)
    types = " or ".join(dict.fromkeys(_types(field)))
    return Key(name, types, unit[1] if unit else "", _default(field, required), about or _text(field), values)


def _text(schema: Schema) -> str:
    return " ".join(schema.get("description", "").split())


def _named(field: Schema) -> Iterator[str]:
    """The values that a field may have by name."""
    for inner in _inside(field):
        yield from (value for value in (*inner.get("enum", ()), inner.get("const")) if isinstance(value, str))


def _split(text: str, names: list[str]) -> tuple[str, dict[str, str]]:
    """What a description says of the key, and what of each of its values: after a semicolon, its name and a colon."""
    about, said, last = list[str](), dict[str, str](), ""
    for piece in text.split("; "):
        name, colon, line = piece.partition(": ")
        if colon and name in names:
            last, said[name] = name, line
        elif piece.startswith("by default") or not last:
            about.append(piece)
        else:
            said[last] += f"; {piece}"
    return "; ".join(about), said


def _types(field: Schema) -> Iterator[str]:
    if "anyOf" in field or "oneOf" in field:
        for inner in (*field.get("anyOf", ()), *field.get("oneOf", ())):
            yield from _types(inner)
    elif "enum" in field or "const" in field:
        yield "name" if any(isinstance(value, str) for value in _named(field)) else "whole number"
    elif "$ref" in field or field.get("type") == "object":
        yield "mapping"
    elif field.get("type") == "array" and "items" in field:
        yield f"list of {' or '.join(dict.fromkeys(_types(field['items'])))}s"
    elif field.get("type", "null") != "null":
        yield _TYPES[field["type"]]
    elif "pattern" in field:
        yield "file"


def _default(field: Schema, required: bool) -> str:
    default = field.get("default")
    if required:
        return NEEDED
    if default is None or default in ("", {}, []):
        return ""
    return BELOW if isinstance(default, dict) else json.dumps(default, ensure_ascii=False)
