"""Text to Spec: with all its faults at once, and what can be read of the rest so that it is checked along with them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from copy import deepcopy
from dataclasses import dataclass
from typing import Annotated, Any, TypeVar, get_args, get_origin

from pydantic import BaseModel, ValidationError

from graspdsl.diagnostics import Diagnostic, DiagnosticError, in_reading_order
from graspdsl.places.document import Document, Path, parse_with_faults
from graspdsl.places.validation import alternatives, validation_faults, with_known_keys
from graspdsl.spec.growing import adapter, schema_of
from graspdsl.spec.models import Spec
from graspdsl.spec.overrides import apply_overrides

M = TypeVar("M", bound=BaseModel)
_ABSENT = object()

Known = Mapping[str, Mapping[str, str]]  # by table, a line on each thing by its name
ANYTHING: Known = {}


@dataclass(frozen=True, slots=True)
class Reading:
    """What became of a text: its document (overrides applied), all faults, and the spec.

    Of a section with faults stands in ``spec`` what can be read of it: a value that could not be read, or that is
    needed and missing, is None there, whatever its type says. ``unread`` are the paths of such values.
    """

    document: Document
    spec: Spec
    faults: tuple[Diagnostic, ...]
    unread: frozenset[Path] = frozenset()

    def is_sound(self, *sections: str) -> bool:
        """Whether some sections have been read as they are written."""
        return not any(path[:1] == (section,) for path in self.unread for section in sections)


@dataclass(frozen=True, slots=True)
class Written:
    """What a text says: its document (overrides applied), all faults of that, and the paths of what is unreadable."""

    document: Document
    faults: tuple[Diagnostic, ...]
    unreadable: frozenset[Path]


def read_document(text: str, name: str, overrides: Sequence[str] = ()) -> Written:
    """What a text says that messages call ``name``, with ``overrides`` (``"scene.friction=0.6"``) in place of what it
    says itself. Raises :class:`DiagnosticError` when there is no reading it at all."""
    document, faults = parse_with_faults(text, name)
    document, refused = apply_overrides(document, overrides)
    unreadable = frozenset(path for path, _ in faults if path is not None)
    return Written(document, (*refused, *(fault for _, fault in faults)), unreadable)


def read_spec(text: str, name: str, overrides: Sequence[str] = (), known: Known = ANYTHING) -> Reading:
    """The reading of a text, as of :func:`read_document` and :func:`spec_of`."""
    return spec_of(read_document(text, name, overrides), known)


def spec_of(written: Written, known: Known = ANYTHING) -> Reading:
    """The reading of what is written; ``known``: the worlds, mounts and grades that it may name, any where none are
    given."""
    document, faults = written.document, list(written.faults)
    try:
        return Reading(document, Spec.model_validate(document.data, context=known), tuple(faults))
    except ValidationError:
        document, key_faults = with_known_keys(document, Spec)
        faults += key_faults
    try:
        return Reading(document, Spec.model_validate(document.data, context=known), tuple(faults))
    except ValidationError as error:
        found = validation_faults(error, document, Spec)
    # What could not be read has had its complaint; what follows from it needs none.
    unread = written.unreadable
    faults += [fault for path, fault in found if not any(path[:n] in unread for n in range(1, len(path) + 1))]
    return Reading(document, _best(Spec, document.data, known), tuple(faults), frozenset(path for path, _ in found))


def load_spec_text(text: str, name: str, overrides: Sequence[str] = ()) -> Reading:
    """The reading of a text without faults. Raises :class:`DiagnosticError` with all those of any other."""
    reading = read_spec(text, name, overrides)
    if reading.faults:
        raise DiagnosticError(in_reading_order(reading.faults))
    return reading


def json_schema(known: Known = ANYTHING) -> dict[str, Any]:
    """The JSON Schema of a spec, for editors; ``known`` as for :func:`spec_of`."""
    schema = deepcopy(dict(schema_of(Spec)))
    scene, grades = schema["$defs"]["Scene"]["properties"], schema["properties"]["evaluate"]
    for table, field in (("worlds", scene["world"]), ("mounts", scene["mount"]), ("grades", grades)):
        if things := known.get(table):
            named = {"enum": list(things)}
            into = grades["items"] if field is grades else field
            into |= {"anyOf": [named, {"pattern": r"\.ya?ml$"}]} if table == "mounts" else named
            field["description"] += "".join(f"; {name}: {line}" for name, line in things.items())
    return {"$schema": "https://json-schema.org/draft/2020-12/schema", **schema, "title": "graspdsl spec"}


def _best(model: type[M], data: object, known: Known) -> M:
    """What can be read of faulty data, field by field; not validated as a whole."""
    given = data if isinstance(data, dict) else {}
    values = {}
    for name, field in model.model_fields.items():
        key = field.alias or name
        if key in given:
            kind: Any = Annotated[(field.annotation, *field.metadata)] if field.metadata else field.annotation
            values[key] = _value(kind, given[key], known)
        elif field.is_required():
            values[key] = _rest(field.annotation, _ABSENT, known)
    return model.model_construct(**values)


def _value(annotation: Any, value: object, known: Known) -> Any:
    try:
        return adapter(annotation).validate_python(value, context=known)
    except ValidationError:
        return _rest(annotation, value, known)


def _rest(annotation: Any, value: object, known: Known) -> Any:
    """What can be read of a faulty value: the fields of a model, the items of a mapping or a list; else None."""
    kinds = [kind for kind in alternatives(annotation) if kind is not type(None)]
    models = [kind for kind in kinds if isinstance(kind, type) and issubclass(kind, BaseModel)]
    if len(models) == 1 and (isinstance(value, dict) or len(kinds) == 1):
        return _best(models[0], value, known)
    origin, arguments = (get_origin(kinds[0]), get_args(kinds[0])) if len(kinds) == 1 else (None, ())
    if origin is dict:
        return (
            {key: _value(arguments[1], item, known) for key, item in value.items()} if isinstance(value, dict) else {}
        )
    if origin is tuple and arguments[-1] is ...:
        return tuple(_value(arguments[0], item, known) for item in (value if isinstance(value, list) else ()))
    return None
