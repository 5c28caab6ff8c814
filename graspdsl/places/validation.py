"""Holds a document against a model; what pydantic finds becomes diagnostics with places and plain words."""

from __future__ import annotations

import json
import re
import types
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Annotated, Any, TypeVar, Union, get_args, get_origin

from pydantic import BaseModel, ValidationError
from pydantic.fields import FieldInfo
from pydantic_core import ErrorDetails

from graspdsl.diagnostics import (
    Diagnostic,
    DiagnosticError,
    Fix,
    Span,
    in_reading_order,
    known_names_hint,
    likely,
    listed,
    nearest,
)
from graspdsl.places.composing import kind_of
from graspdsl.places.document import Document, Path
from graspdsl.places.fields import FORM, Model, Unit
from graspdsl.places.mending import key_added
from graspdsl.places.wording import Data, as_yaml, quoted, shortened, shown
from graspdsl.units import number_meant


@dataclass(frozen=True, slots=True)
class Slot:
    """What may stand at a path: the models, and for a number its unit."""

    models: tuple[type[BaseModel], ...]
    unit: str | None

    def fields(self) -> dict[str, FieldInfo]:
        """The fields that may stand here, by the keys they have in a file."""
        return {field.alias or name: field for model in self.models for name, field in model.model_fields.items()}

    def meant_by(self, key: str) -> str | None:
        """The hint for a key that none of the models has, where one of them knows what is meant by it."""
        hints = (model.meant_by.get(key) for model in self.models if issubclass(model, Model))
        return next((hint for hint in hints if hint is not None), None)


def slot(model: type[BaseModel], path: Path) -> Slot:
    """What ``model`` says about ``path``; nothing for a path it does not know."""
    parts = kinds_at(model, path)
    models = tuple(part for part in parts if isinstance(part, type) and issubclass(part, BaseModel))
    unit = next((part.symbol for part in parts if isinstance(part, Unit)), None)
    return Slot(models, unit)


def kinds_at(model: type[BaseModel], path: Path) -> list[Any]:
    """The types that ``model`` has for the value at ``path``, with what is attached to them; none of no known one."""
    here: list[Any] = [model]
    for step in path:
        here = [inner for annotation in here for inner in _inside(annotation, step)]
    return [part for annotation in here for part in _parts(annotation)]


def _parts(annotation: Any) -> Iterator[Any]:
    """The alternatives of an annotation, and what is attached to them."""
    origin = get_origin(annotation)
    if origin is Annotated or origin in (Union, types.UnionType):
        for part in get_args(annotation):
            yield from _parts(part)
    else:
        yield annotation


def alternatives(annotation: Any) -> list[Any]:
    """The types that a value of an annotation may have."""
    return [part for part in _parts(annotation) if isinstance(part, type) or get_origin(part) is not None]


def _inside(annotation: Any, step: str | int) -> Iterator[Any]:
    """The annotations of what stands under ``step`` in a value."""
    for part in _parts(annotation):
        origin, arguments = get_origin(part), get_args(part)
        if isinstance(part, type) and issubclass(part, BaseModel):
            for name, field in part.model_fields.items():
                if (field.alias or name) == step:
                    yield field.annotation
                    yield from field.metadata
        elif origin is dict and isinstance(step, str):
            yield arguments[1]
        elif origin is tuple and isinstance(step, int):
            yield arguments[0]


M = TypeVar("M", bound=BaseModel)

# pydantic's name of a fault: (what was expected, whether it takes a unit)
_TYPES = {
    "float_type": ("a number", True),
    "int_type": ("a whole number", True),
    "string_type": ("text", False),
    "bool_type": ("true or false", False),
    "list_type": ("a list", False),
    "tuple_type": ("a list", False),
    "dict_type": ("a mapping", False),
    "model_type": ("a mapping", False),
    "model_attributes_type": ("a mapping", False),
}
_BOUNDS = {
    "greater_than": ("gt", "above"),
    "greater_than_equal": ("ge", "of at least"),
    "less_than": ("lt", "below"),
    "less_than_equal": ("le", "of at most"),
}
_UNIT_HINTS = {"m": "lengths are in metres", "rad": "angles are in radians"}
MISSPELT = 0.65  # the likeness from which a key is read as another that is absent
_COUNTED = re.compile(r"([0-9]+(?:\.[0-9]+)?) [^\W\d_]")  # with a unit of no other kind, as in 58 trials
_LIKE_A_FILE = re.compile(r"[/\\]|\.[a-z]{2,5}\Z", re.IGNORECASE)
_ODD_QUOTES = "“”„«»‘’"
_LENGTHS = {
    "too_short": ("min_length", "at least"),
    "too_long": ("max_length", "at most"),
    "string_too_short": ("min_length", "at least"),
    "string_too_long": ("max_length", "at most"),
}


def validate_document(document: Document, model: type[M]) -> M:
    """The document as a ``model``.

    Raises :class:`DiagnosticError` with every fault of the document, in reading order.
    """
    document, faults = with_known_keys(document, model)
    try:
        valid = model.model_validate(document.data)
    except ValidationError as error:
        faults += [fault for _, fault in validation_faults(error, document, model)]
    if faults:
        raise DiagnosticError(in_reading_order(faults))
    return valid


def with_known_keys(document: Document, model: type[BaseModel]) -> tuple[Document, list[Diagnostic]]:
    """The document with known keys in place of misspelt ones, so that nothing follows from these; and their faults."""
    names: dict[Path, str] = {}
    faults: list[Diagnostic] = []
    waiting: list[tuple[Path, Data]] = [((), document.data)]
    while waiting:
        path, data = waiting.pop()
        if isinstance(data, list):
            waiting += [((*path, number), item) for number, item in enumerate(data)]
        if not isinstance(data, dict):
            continue
        waiting += [((*path, key), value) for key, value in data.items()]
        around = slot(model, path)
        absent = around.fields().keys() - data.keys() if len(around.models) == 1 else set()
        for key in data.keys() - around.fields().keys() if absent else ():
            meant = nearest(key, sorted(around.fields()), 1, MISSPELT)
            if meant and meant[0] in absent and around.meant_by(key) is None:
                absent -= {meant[0]}
                names[(*path, key)] = meant[0]
                faults.append(document.attributed((*path, key), _unknown_key((*path, key), document, around)))
    return (document.renamed(names) if names else document), faults


def validation_faults(
    error: ValidationError, document: Document, model: type[BaseModel]
) -> list[tuple[Path, Diagnostic]]:
    """What pydantic found in a document, each with the path it is about."""
    found = [(_path(details["loc"], document.data), details) for details in error.errors(include_url=False)]
    faults = []
    for path, details in found:
        if details["type"] == "too_short" and len(details["input"]) >= details["ctx"]["min_length"]:
            continue  # pydantic counts only the items that are right
        faults.append((path, document.attributed(path, _diagnostic(details, path, document, model))))
    return faults


def _path(location: tuple[int | str, ...], data: Data) -> Path:
    """A location of pydantic's without the names of alternative forms."""
    path: Path = ()
    at: Any = data
    for step in location:
        known = isinstance(at, dict) and step in at
        if isinstance(step, str) and step.startswith(FORM) and not known:
            continue
        path = (*path, step)
        at = at[step] if known or (isinstance(at, list) and step in range(len(at))) else None
    return path


def _diagnostic(details: ErrorDetails, path: Path, document: Document, model: type[BaseModel]) -> Diagnostic:
    kind, value = details["type"], details["input"]
    context: Mapping[str, Any] = details.get("ctx") or {}
    here = slot(model, path)
    unit = f" ({here.unit})" if here.unit else ""
    if kind == "missing":
        return _missing(path, document, slot(model, path[:-1]))
    if kind == "extra_forbidden":
        return _unknown_key(path, document, slot(model, path[:-1]))
    code, message, hint = "wrong-value", f"{details['msg']}, found {shown(value)}", None
    write: str | None = None
    fixes: tuple[Fix, ...] = ()
    if kind in _TYPES:
        expected, takes_unit = _TYPES[kind]
        code, message = "wrong-type", f"expected {expected}{unit if takes_unit else ''}, found {shown(value)}"
        if "number" in expected:
            hint, write = _number_hint(value, path, model)
        found = Diagnostic(code, message, document.span(path), hint, fixes=_instead(document.span(path), write))
        return _type_fault(found, expected, value, path, document, model)
    if kind in _BOUNDS:
        key, words = _BOUNDS[kind]
        code = "out-of-range"
        message = f"expected a number {words} {as_yaml(context[key])}{unit}, found {as_yaml(value)}"
        hint = _UNIT_HINTS.get(here.unit or "")
    elif kind in _LENGTHS:
        key, words = _LENGTHS[kind]
        what = "character" if kind.startswith("string") else "item"
        plural = "" if context[key] == 1 else "s"
        code, message = "wrong-length", f"expected {words} {context[key]} {what}{plural}, found {len(value)}"
    elif kind == "finite_number":
        code, message = "not-finite", f"expected a finite number{unit}, found {as_yaml(value)}"
    elif kind == "literal_error":
        known = [name.strip(" '") for name in context["expected"].replace(" or ", ",").split(",")]
        code, (message, hint) = "unknown-value", unknown_value(known, value)
        fixes = likely(value, known, document.span(path)) if isinstance(value, str) else ()
    elif kind == "wrong-form":
        code, message, hint = "wrong-form", details["msg"], context.get("hint")
        if not context:  # a value that has none of the forms; one with context says it all
            message = f"{message}{unit and f', in {here.unit}'}; found {shown(value)}"
            hint, fixes = _form_hint(value, here), _form_fixes(value, here, path, document)
            if "a number" in message and isinstance(value, str):
                hint, write = _number_hint(value, path, model)
    elif "message" in context:
        code, message, hint, write = kind, str(context["message"]), context.get("hint"), context.get("write")
    span = document.span(path)
    return Diagnostic(code, message, span, hint, fixes=fixes or _instead(span, write))


def _instead(span: Span | None, text: str | None) -> tuple[Fix, ...]:
    return () if span is None or text is None else (Fix(span, text),)


def _missing(path: Path, document: Document, around: Slot) -> Diagnostic:
    key = str(path[-1])
    field = around.fields().get(key)
    owner = _owner(path[:-1])
    hint: str | None = None
    fixes: tuple[Fix, ...] = ()
    if field is not None:
        said = f"{key}: {_example(field.examples)}"
        hint = f"add '{said}'" + (f" ({field.description})" if field.description else "")
        fixes = key_added(document, path, said, list(around.fields())) if field.examples else ()
    message = f"{owner} needs the key '{key}'"
    return Diagnostic("missing-key", message, document.key_span(path[:-1]), hint, fixes=fixes)


def _owner(path: Path) -> str:
    if not path:
        return "the file"
    if isinstance(path[-1], int):
        return f"item {path[-1] + 1} of {_owner(path[:-1])}"
    return f"'{shortened(path[-1])}'"


def _example(examples: list[Any] | None) -> str:
    value = (examples or ["…"])[0]
    # Only a set of resources needs its quotes.
    return value if isinstance(value, str) else re.sub('"([^"{]*)"', r"\1", json.dumps(value, ensure_ascii=False))


def _unknown_key(path: Path, document: Document, around: Slot) -> Diagnostic:
    key = str(path[-1])
    meant, span = around.meant_by(key.replace("_", "-")), document.key_span(path)
    hint = meant or known_names_hint(key, around.fields(), "keys here")
    absent = [name for name in around.fields() if not document.has((*path[:-1], name))]
    message = f"{_owner(path[:-1])} has no key {shortened(key)!r}"
    return Diagnostic("unknown-key", message, span, hint, fixes=() if meant else likely(key, absent, span))


def _type_fault(
    found: Diagnostic, expected: str, value: object, path: Path, document: Document, model: type[BaseModel]
) -> Diagnostic:
    """Adds the way out that fits: quotes around a formula, or a number without its quotes."""
    code, message, hint = found.code, found.message, found.hint
    write: str | None = None
    source = document.source(path)
    file = value.get("file") if isinstance(value, dict) else None
    if expected == "text" and isinstance(file, str):
        hint = f"write {path[-1]}: {shortened(file)}"
    elif expected == "text" and isinstance(value, dict | list) and document.is_flow(path) and source:
        what = "mapping" if isinstance(value, dict) else "list"
        code = "unquoted-text"
        message = f"expected text, but without quotes YAML reads this as a {what}"
        write = quoted(source)
        hint = f"put it in quotes: {write}"
    elif expected == "text" and source is None and isinstance(value, dict | list):
        hint = "put quotes around the value as well as around what the shell takes"
    elif expected == "text" and isinstance(value, bool | int | float):
        write = quoted(source or as_yaml(value))
        hint = f"put it in quotes: {write}"
    elif expected == "a whole number" and isinstance(value, float) and value.is_integer():
        write = f"{value:.0f}"
        hint = f"write {write}"
    elif hint is None and isinstance(value, str) and value[:1] in "“”„«‘":
        write = quoted(value.strip(_ODD_QUOTES))
        hint = f"YAML's quotation marks are \" and ': write {write}"
    elif expected == "a mapping" and isinstance(value, str) and "file" in slot(model, path).fields():
        hint = f"write {path[-1]}: {{file: {shortened(value)}}}"
    elif expected in ("a mapping", "a list") and isinstance(value, str) and _LIKE_A_FILE.search(value):
        hint = f"{expected} stands here itself, not the name of a file"
    return Diagnostic(code, message, found.span, hint, fixes=_instead(found.span, write) or found.fixes)


def _number_hint(value: object, path: Path, model: type[BaseModel]) -> tuple[str | None, str | None]:
    """For a text where a number is needed, the number that it means, bare and in the unit of the field: the hint, and
    what to write instead."""
    if not isinstance(value, str):
        return None, None
    plain = value.strip().strip(_ODD_QUOTES)
    if kind_of(plain) in ("int", "float"):
        return f"remove the quotes: {plain}", plain
    meant = number_meant(plain)
    if meant is None:
        counted = _COUNTED.match(plain)
        return (f"write the bare number: {counted.group(1)}", counted.group(1)) if counted else (None, None)
    number, unit = meant
    field = next((at.unit for n in range(len(path), 0, -1) if (at := slot(model, path[:n])).unit), None)
    if unit is not None and field is not None and unit != field:
        return f"write the bare number, in {field}", None
    bare = as_yaml(float(f"{number:.6g}"))
    said = field or (unit if not plain.startswith(bare) else None)
    return f"write the bare number{f', in {said}' if said else ''}: {bare}", bare


def unknown_value(known: Sequence[str], value: object) -> tuple[str, str | None]:
    """What to say of a value that is none of those known: the message, and a hint at what was meant."""
    close = nearest(value, known) if isinstance(value, str) else []
    hint = f"did you mean {listed(close, 'or')}?" if close else None
    return f"expected {listed(known, 'or')}, found {shown(value)}", hint


def _form_hint(value: object, here: Slot) -> str | None:
    """For a mapping with a misspelt key, what was meant."""
    if not isinstance(value, dict):
        return None
    known = here.fields()
    close = [name for key in value if key not in known for name in nearest(str(key), known, 1)]
    if close:
        return f"did you mean {listed(dict.fromkeys(close), 'or')}?"
    return "write exactly one of them" if sum(key in known for key in value) > 1 else None


def _form_fixes(value: object, here: Slot, path: Path, document: Document) -> tuple[Fix, ...]:
    """For a mapping with a misspelt key, the keys that were meant, in its place."""
    unknown = [key for key in value if key not in here.fields()] if isinstance(value, dict) else []
    return tuple(fix for key in unknown for fix in likely(key, here.fields(), document.key_span((*path, key)))[:1])
