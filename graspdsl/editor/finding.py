"""Where things are: the definition of a name, and the outline of a file."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from pathlib import Path as FilePath

from graspdsl.basis import prelude as prelude_room
from graspdsl.basis.prelude import prelude
from graspdsl.diagnostics import Span
from graspdsl.editor.cursor import cursor_at
from graspdsl.editor.names import CONTROLLER, definition_of, use_at
from graspdsl.editor.sheet import Place, sheet_of
from graspdsl.notation.names import canonical
from graspdsl.notation.parser import parse_head
from graspdsl.places.document import Document, Path, parse_document
from graspdsl.places.files import read_text, with_plain_line_ends
from graspdsl.places.folders import names_a_file

PRELUDE = FilePath(prelude_room.__file__).with_name("prelude.yaml")
START = Span(1, 1, 1, 1)


@dataclass(frozen=True, slots=True)
class Target:
    """Where something is defined: a span of a file, or of the text itself where there is no file."""

    file: FilePath | None
    span: Span


def target_of(text: str, place: Place, folder: FilePath) -> Target | None:
    """The definition of the name at a place, in the text or in the prelude; of a hand or a mount that is a file, that
    file, which a relative name has in the folder."""
    text = with_plain_line_ends(text)
    sheet = sheet_of(text)
    if sheet is None:
        return None
    use = use_at(sheet, place)
    if use is None:
        return _file(sheet.document, cursor_at(text, place).path, folder)
    found = definition_of(sheet, use)
    if found is not None:
        return Target(None, found.span)
    if use.what == CONTROLLER and use.name in prelude():
        return Target(PRELUDE, _in_prelude()[use.name])
    return None


@cache
def _in_prelude() -> dict[str, Span]:
    document = parse_document(read_text(PRELUDE), PRELUDE.name)
    heads = document.data["controllers"]
    assert isinstance(heads, dict)
    keys = (document.key_source_text(("controllers", head)) for head in heads)
    return {parse_head(key).name.text: parse_head(key).name.span for key in keys}


def _file(document: Document, path: Path, folder: FilePath) -> Target | None:
    if path not in (("scene", "hand"), ("scene", "mount")) or not document.has(path):
        return None
    name = document.get(path)
    if not isinstance(name, str) or not names_a_file(name) or not (folder / name).is_file():
        return None
    return Target((folder / name).resolve(), START)


@dataclass(frozen=True, slots=True)
class Symbol:
    """An entry of an outline: its name and a line on it, what it takes in the text, its key, what is in it."""

    name: str
    about: str
    kind: str
    span: Span
    key: Span
    inside: tuple[Symbol, ...] = ()


_KINDS = {"resources": "resource", "parameters": "parameter", "controllers": "controller", "program": "phase"}


def outline(text: str) -> tuple[Symbol, ...]:
    """The keys of a file, with the resources, parameters, controllers and phases of a spec; none of what is no YAML."""
    sheet = sheet_of(text)
    if sheet is None:
        return ()
    document = sheet.document
    return tuple(_symbol(document, (key,), "section") for key in document.data)


def _symbol(document: Document, path: Path, kind: str) -> Symbol:
    data, span, key = document.get(path), document.span(path), document.key_span(path)
    assert span is not None
    assert key is not None
    inner: tuple[Symbol, ...] = ()
    if len(path) == 1 and path[0] in _KINDS:
        steps = data if isinstance(data, dict) else range(len(data)) if isinstance(data, list) else ()
        inner = tuple(_symbol(document, (*path, step), _KINDS[str(path[0])]) for step in steps)
    name, about = str(path[-1]), data if isinstance(data, str) else ""
    if kind == "phase" and isinstance(data, dict):
        name, about = str(data.get("run", "")) or f"phase {path[-1]}", ""
    elif kind == "controller" and isinstance(data, dict):
        about = str(data.get("is", ""))
    elif kind in ("resource", "parameter"):
        name = canonical(name)
    whole = key.to(span) if (key.line, key.column) < (span.line, span.column) else span
    return Symbol(name or '""', about, kind, whole, key, inner)
