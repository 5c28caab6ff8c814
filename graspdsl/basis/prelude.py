"""The prelude: controllers by name, written in the notation, and those of other packages beside them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from pathlib import Path as FilePath

from pydantic import VERSION, Field

from graspdsl.diagnostics import Diagnostic, DiagnosticError, in_reading_order
from graspdsl.notation.parser import parse_expression, parse_head
from graspdsl.notation.tree import Expression, Head
from graspdsl.places.document import Path, parse_document
from graspdsl.places.fields import Model
from graspdsl.places.files import read_text
from graspdsl.places.kept import kept
from graspdsl.places.validation import validate_document
from graspdsl.spec.models import ControllerDefinition, ControllerEntry


@dataclass(frozen=True, slots=True)
class Definition:
    """head ≡ body, with the equation that it comes from and what it is for. ``path``: where a spec has the body.

    ``in_prelude``: it is none of a spec's own; ``by``: the package that it comes with, where that is another one. A
    ``body`` of None stands for one that could not be read or that has faults, which has had its complaints.
    """

    head: Head
    body: Expression | None
    equation: str = ""
    about: str = ""
    in_prelude: bool = False
    path: Path = ()
    by: str = ""

    @property
    def parameters(self) -> tuple[str, ...]:
        """The names in the head that a use puts its own resources and reference in place of."""
        reference = () if self.head.reference is None else (self.head.reference,)
        return tuple(name.text for name in (*self.head.effector, *self.head.sensor, *reference))


@cache
def prelude() -> Mapping[str, Definition]:
    """The chapter's controllers by name."""
    file = FilePath(__file__).with_name("prelude.yaml")
    return kept("prelude", VERSION, lambda: definitions_in(file))


class _File(Model):
    controllers: dict[str, ControllerEntry] = Field(min_length=1)


def definitions_in(file: FilePath, by: str = "") -> dict[str, Definition]:
    """The controllers in a file, by name, as the prelude has them; ``by``: the package that it comes with.

    Raises DiagnosticError with every fault of the file.
    """
    document = parse_document(read_text(file), file.name)
    faults: list[Diagnostic] = []
    found: dict[str, Definition] = {}
    for key, entry in validate_document(document, _File).controllers.items():
        path: Path = ("controllers", key)
        place, equation, about = (path, "", "")
        if isinstance(entry, ControllerDefinition):
            place, equation, about = (*path, "is"), entry.equation, entry.about
        try:
            head, stands_for = parse_head(document.key_source_text(path)), parse_expression(document.source_text(place))
        except DiagnosticError as error:
            faults += error.diagnostics
            continue
        found[head.name.text] = Definition(head, stands_for, equation, about, in_prelude=True, by=by)
    if faults:
        raise DiagnosticError(in_reading_order(faults))
    return found
