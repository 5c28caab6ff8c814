"""Holds a document against a model; what pydantic finds becomes diagnostics with places and plain words."""

from __future__ import annotations

import json
import re
from collections.abc import Mapping, Sequence
from typing import Any, TypeVar

from pydantic import BaseModel, ValidationError
from pydantic_core import ErrorDetails

from graspdsl.diagnostics import Diagnostic, DiagnosticError, in_reading_order, known_names_hint, listed, nearest
from graspdsl.spec.composing import kind_of
from graspdsl.spec.constructing import Path
from graspdsl.spec.document import Document
from graspdsl.spec.fields import FORM
from graspdsl.spec.model_paths import Slot, slot
from graspdsl.spec.wording import Data, as_yaml, quoted, shortened, shown
from graspdsl.units import number_meant

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
    if kind in _TYPES:
        expected, takes_unit = _TYPES[kind]
        code, message = "wrong-type", f"expected {expected}{unit if takes_unit else ''}, found {shown(value)}"
        if "number" in expected:
            hint = _number_hint(value, path, model)
        return _type_fault(Diagnostic(code, message, document.span(path), hint), expected, value, path, document, model)
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
    elif kind == "wrong-form":
        code, message, hint = "wrong-form", details["msg"], context.get("hint")
        if not context:  # a value that has none of the forms; one with context says it all
            message = f"{message}{unit and f', in {here.unit}'}; found {shown(value)}"
            hint = _form_hint(value, here)
            if "a number" in message and isinstance(value, str):
                hint = _number_hint(value, path, model)
    elif "message" in context:
        code, message, hint = kind, str(context["message"]), context.get("hint")
    return Diagnostic(code, message, document.span(path), hint)


def _missing(path: Path, document: Document, around: Slot) -> Diagnostic:
    key = str(path[-1])
    field = around.fields().get(key)
    owner = _owner(path[:-1])
    hint = None
    if field is not None:
        hint = f"add '{key}: {_example(field.examples)}'" if field.examples else f"add '{key}: …'"
        hint += f" ({field.description})" if field.description else ""
    return Diagnostic("missing-key", f"{owner} needs the key '{key}'", document.key_span(path[:-1]), hint)


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
    hint = around.meant_by(key.replace("_", "-")) or known_names_hint(key, around.fields(), "keys here")
    message = f"{_owner(path[:-1])} has no key {shortened(key)!r}"
    return Diagnostic("unknown-key", message, document.key_span(path), hint)


def _type_fault(
    found: Diagnostic, expected: str, value: object, path: Path, document: Document, model: type[BaseModel]
) -> Diagnostic:
    """Adds the way out that fits: quotes around a formula, or a number without its quotes."""
    code, message, hint = found.code, found.message, found.hint
    source = document.source(path)
    file = value.get("file") if isinstance(value, dict) else None
    if expected == "text" and isinstance(file, str):
        hint = f"write {path[-1]}: {shortened(file)}"
    elif expected == "text" and isinstance(value, dict | list) and document.is_flow(path) and source:
        what = "mapping" if isinstance(value, dict) else "list"
        code = "unquoted-text"
        message = f"expected text, but without quotes YAML reads this as a {what}"
        hint = f"put it in quotes: {quoted(source)}"
    elif expected == "text" and source is None and isinstance(value, dict | list):
        hint = "put quotes around the value as well as around what the shell takes"
    elif expected == "text" and isinstance(value, bool | int | float):
        hint = f"put it in quotes: {quoted(source or as_yaml(value))}"
    elif expected == "a whole number" and isinstance(value, float) and value.is_integer():
        hint = f"write {value:.0f}"
    elif hint is None and isinstance(value, str) and value[:1] in "“”„«‘":
        hint = f"YAML's quotation marks are \" and ': write {quoted(value.strip(_ODD_QUOTES))}"
    elif expected == "a mapping" and isinstance(value, str) and "file" in slot(model, path).fields():
        hint = f"write {path[-1]}: {{file: {shortened(value)}}}"
    elif expected in ("a mapping", "a list") and isinstance(value, str) and _LIKE_A_FILE.search(value):
        hint = f"{expected} stands here itself, not the name of a file"
    return Diagnostic(code, message, found.span, hint)


def _number_hint(value: object, path: Path, model: type[BaseModel]) -> str | None:
    """For a text where a number is needed, the number that it means, bare and in the unit of the field."""
    if not isinstance(value, str):
        return None
    plain = value.strip().strip(_ODD_QUOTES)
    if kind_of(plain) in ("int", "float"):
        return f"remove the quotes: {plain}"
    meant = number_meant(plain)
    if meant is None:
        counted = _COUNTED.match(plain)
        return f"write the bare number: {counted.group(1)}" if counted else None
    number, unit = meant
    field = next((at.unit for n in range(len(path), 0, -1) if (at := slot(model, path[:n])).unit), None)
    if unit is not None and field is not None and unit != field:
        return f"write the bare number, in {field}"
    bare = as_yaml(float(f"{number:.6g}"))
    said = field or (unit if not plain.startswith(bare) else None)
    return f"write the bare number{f', in {said}' if said else ''}: {bare}"


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
