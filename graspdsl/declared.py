"""What a base class declares of the classes that are written from it, held against one of them."""

from __future__ import annotations

import inspect
from collections.abc import Iterator
from typing import Any, ClassVar, get_args, get_origin, get_type_hints

from pydantic import TypeAdapter, ValidationError


def misdeclared(entry: object, base: type) -> Iterator[tuple[str, str]]:
    """What the base declares and an entry, a class or an instance of one, has not, or has of another type: what is
    wrong, and what would be right."""
    for name, annotation in get_type_hints(base).items():
        if get_origin(annotation) is not ClassVar or name.startswith(("_", "model_")):  # the latter are pydantic's
            continue
        (wanted,) = get_args(annotation)
        if not hasattr(entry, name):
            yield f"{name} is not said", f"say {name}, {_spelt(wanted)}"
        elif not _is(getattr(entry, name), wanted):
            found = getattr(entry, name)
            hint = f"write ({found!r},): a tuple of one has a comma" if isinstance(found, str) else ""
            yield f"{name} is {_spelt(wanted)}, found {found!r}", hint or f"give {name} as {_spelt(wanted)}"


def _is(value: object, wanted: Any) -> bool:
    if inspect.isclass(wanted) and wanted is not Any:
        return isinstance(value, (int, float) if wanted is float else wanted)
    try:
        TypeAdapter(wanted).validate_python(value, strict=True)
    except ValidationError:
        return False
    return True


def _spelt(wanted: Any) -> str:
    return wanted.__name__ if inspect.isclass(wanted) else str(wanted).replace("typing.", "")
