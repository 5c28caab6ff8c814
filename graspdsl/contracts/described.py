"""What descriptions have to keep alike: a name, a line, and what the check of their files says."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator

import yaml
from pydantic_core import PydanticCustomError

from graspdsl.contracts.rule import Breach
from graspdsl.diagnostics import Diagnostic, has_errors
from graspdsl.places.document import Document, parse_document
from graspdsl.places.fields import Model
from graspdsl.spec.models import folder_name


def is_named(name: str) -> Iterator[Breach]:
    """The name can stand in a spec and name a folder."""
    try:
        folder_name(name)
    except PydanticCustomError as error:
        yield error.message(), "up to 60 letters, digits, '-', '_' and '.'"


def is_told(about: str) -> Iterator[Breach]:
    """There is a line that says what it is."""
    if not about.strip() or "\n" in about.strip():
        yield f"its about is {about!r}", "say in one line what it is"


def faults_of(description: Model, check: Callable[[Document], Iterable[Diagnostic]]) -> Iterator[Breach]:
    """The errors that a check finds in the file of a description."""
    text = yaml.safe_dump(description.model_dump(mode="json", exclude_defaults=True), allow_unicode=True)
    for fault in check(parse_document(text, "")):
        if has_errors([fault]):
            yield fault.message, fault.hint or ""
