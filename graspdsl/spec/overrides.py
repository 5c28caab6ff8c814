"""Values given on the command line instead of in the file: ``--set scene.friction=0.6``."""

from __future__ import annotations

import re
from collections.abc import Sequence

from graspdsl.diagnostics import Diagnostic, DiagnosticError, known_names_hint
from graspdsl.objects.object_files import FILES
from graspdsl.objects.shapes import SHAPES
from graspdsl.places.document import Document, Path, parse_value
from graspdsl.places.files import SIZE_LIMIT
from graspdsl.places.positions import Lines
from graspdsl.places.wording import Data, shortened, shown
from graspdsl.spec.scene import InlineObject

_ONE_OF_SEVERAL = re.compile(r"""[^\s\\\[\](){}<>"']+|\[.*\]|\{.*\}|<.*>|".*"|'.*'""", re.DOTALL)
_OF_ANY_OBJECT = InlineObject.model_fields.keys() - {*SHAPES, *FILES, "like"}


def apply_overrides(document: Document, overrides: Sequence[str]) -> tuple[Document, list[Diagnostic]]:
    """The document with the overrides applied in their order, and what is wrong with those that could not be.

    An override is ``dotted.path=YAML value``. A number names an item of a list, from 0; a mapping that the file
    leaves out is added, also where the file has only its name: ``load-cell`` for ``{load-cell: {}}``. Several values,
    ``scene.friction=0.3,0.6``, are those of a grid of a sweep.
    """
    faults: list[Diagnostic] = []
    for override in overrides:
        try:
            document = _applied(document, override)
        except DiagnosticError as error:
            faults += error.diagnostics
    return document, faults


def _refused(origin: str, code: str, message: str, hint: str | None) -> DiagnosticError:
    return DiagnosticError([Diagnostic(code, f"{origin}: {message}", None, hint)])


def makes_sweep(override: str) -> bool:
    """Whether an override is of several values, or of the spec's sweep itself."""
    dotted, _, text = override.partition("=")
    return len(_several(text)) > 1 or dotted.strip().split(".")[0] == "sweep"


def origin_of(override: str) -> str:
    """The words that introduce a complaint about an override."""
    return f"in --set {shortened(override)}"


def _applied(document: Document, override: str) -> Document:
    origin = origin_of(override)
    dotted, equals, text = override.partition("=")
    names = dotted.strip().split(".")
    if not equals or not all(names):
        raise _refused(origin, "bad-override", "expected path=value", "for example --set scene.friction=0.6")
    if len(values := _several(text)) > 1:
        return _with_sweep(document, dotted.strip(), [_value(one, origin) for one in values], origin)
    value = _value(text, origin)
    path: Path = ()
    at: Data = document.data
    for position, name in enumerate(names):
        if isinstance(at, str) and at == name and path and position < len(names) - 1:
            document = document.with_value(path, {name: {}}, origin)  # a name stands for it without parameters
            at = {name: {}}
        if isinstance(at, list):
            if not (name.isascii() and name.isdecimal() and int(name[:9]) < len(at)):
                message = f"{_said(path)} is a list of {len(at)}, and {shortened(name)!r} is no number of an item in it"
                hint = f"items are numbered from 0 to {len(at) - 1}" if at else None
                raise _refused(origin, "unknown-path", message, hint)
            path = (*path, int(name))
            at = at[int(name)]
        elif isinstance(at, dict):
            path = (*path, name)
            if name not in at and position < len(names) - 1:
                document = document.with_value(path, {}, origin)
                at = {}
            else:
                at = at.get(name)
        else:
            hint = known_names_hint(names[0], document.data, "keys") if not path else None
            if isinstance(at, str):
                hint = (
                    f"give the whole: --set '{'.'.join(names[:position])}={_whole(at, path, names[position:], text)}'"
                )
            message = f"{_said(path)} is {shown(at)}, which has nothing inside"
            raise _refused(origin, "unknown-path", message, hint)
    return document.with_value(path, value, origin)


def _with_sweep(document: Document, field: str, values: list[Data], origin: str) -> Document:
    """The document with a sweep over values of a field, besides those of the grid that it has."""
    if not document.has(("sweep", "grid")):
        return document.with_value(("sweep",), {"grid": {field: values}}, origin)
    return document.with_value(("sweep", "grid", field), values, origin)


def _several(text: str) -> list[str]:
    """The values in a text that commas part, where each is a bare word or number, or stands in brackets or quotes; else
    the whole text."""
    parts, depth, quote = [""], 0, ""
    for letter in text:
        if quote:
            quote = "" if letter == quote else quote
        elif letter in "\"'":
            quote = letter
        elif letter == "," and not depth:
            parts.append("")
            continue
        depth += 0 if quote else (letter in "[({<") - (letter in "])}>")
        parts[-1] += letter
    values = [part.strip() for part in parts]
    return values if all(map(_ONE_OF_SEVERAL.fullmatch, values)) else [text]


def _whole(name: str, path: Path, names: Sequence[str], text: str) -> str:
    """The mapping to give instead of a name, with what was to be set inside it."""
    like = f"like: {shortened(name)}, " if path == ("scene", "object") and names[0] in _OF_ANY_OBJECT else ""
    return f"{{{like}{': {'.join(names)}: {shortened(text)}{'}' * len(names)}"


def _said(path: Path) -> str:
    return repr(shortened(".".join(str(step) for step in path)))


def _value(text: str, origin: str) -> Data:
    if len(text) > SIZE_LIMIT:
        raise _refused(origin, "file-too-large", "the value is too long", None)
    try:
        value, _, _, faults = parse_value(Lines(text))
    except DiagnosticError as error:
        found = error.diagnostics
    else:
        found = tuple(fault for _, fault in faults)
    if found:
        raise DiagnosticError([Diagnostic(d.code, f"{origin}: {d.message}", None, d.hint) for d in found])
    return value
