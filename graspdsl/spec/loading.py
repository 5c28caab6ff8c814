"""From a spec file to a validated spec, with all its faults at once."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from graspdsl.diagnostics import Diagnostic, DiagnosticError, in_reading_order
from graspdsl.spec.document import Document, parse_with_faults
from graspdsl.spec.files import read_text
from graspdsl.spec.models import Spec
from graspdsl.spec.overrides import apply_overrides
from graspdsl.spec.validation import validation_faults, with_known_keys


@dataclass(frozen=True, slots=True)
class LoadedSpec:
    """A spec, and the document it came from (overrides applied), which knows the place of everything in it."""

    spec: Spec
    document: Document
    text: str
    name: str


def load_spec(path: Path, overrides: Sequence[str] = ()) -> LoadedSpec:
    """The spec of a file, with ``overrides`` (``"scene.friction=0.6"``) in place of what it says.

    Raises :class:`DiagnosticError` with all faults of the file and of the overrides.
    """
    return load_spec_text(read_text(path), path.name, overrides)


def load_spec_text(text: str, name: str, overrides: Sequence[str] = ()) -> LoadedSpec:
    """The spec of a text that messages call ``name``; otherwise as :func:`load_spec`."""
    document, spec, faults = read_spec(text, name, overrides)
    if faults or spec is None:
        raise DiagnosticError(in_reading_order(faults))
    return LoadedSpec(spec, document, document.text, name)


def read_spec(text: str, name: str, overrides: Sequence[str] = ()) -> tuple[Document, Spec | None, list[Diagnostic]]:
    """The document of a text, its spec if it is valid, and all faults, for a caller that goes on to find more.

    Raises :class:`DiagnosticError` when there is no reading the text at all.
    """
    document, reading_faults = parse_with_faults(text, name)
    document, faults = apply_overrides(document, overrides)
    document, key_faults = with_known_keys(document, Spec)
    faults += [*(fault for _, fault in reading_faults), *key_faults]
    try:
        return document, Spec.model_validate(document.data), faults
    except ValidationError as error:
        # What could not be read has had its complaint; what follows from it needs none.
        unread = {path for path, _ in reading_faults if path is not None}
        faults += [
            fault
            for path, fault in validation_faults(error, document, Spec)
            if not any(path[:n] in unread for n in range(1, len(path) + 1))
        ]
    return document, None, faults


def json_schema(grades: Iterable[str] = ()) -> dict[str, Any]:
    """The JSON Schema of a spec, for editors; ``grades``: what ``evaluate`` may hold, any text where none are given."""
    schema = Spec.model_json_schema(by_alias=True)
    if known := list(grades):
        schema["properties"]["evaluate"]["items"] = {"enum": known, "type": "string"}
    return {"$schema": "https://json-schema.org/draft/2020-12/schema", **schema, "title": "graspdsl spec"}
