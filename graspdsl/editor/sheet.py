"""What can be read of the text of a spec while it is written: its document, its formulas and what they may name."""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path as FilePath
from typing import TypeVar

from graspdsl.basis.prelude import Definition
from graspdsl.compiler.complaints import Complaints
from graspdsl.compiler.declarations import Declarations, declarations_of
from graspdsl.compiler.definitions import definitions_with
from graspdsl.compiler.program import known_names
from graspdsl.compiler.resources import is_formula
from graspdsl.diagnostics import DiagnosticError, SourceText, Span
from graspdsl.hands.description_files import DescriptionFileError
from graspdsl.hands.descriptions import Hand, Mount, Robot, hands, mounts
from graspdsl.hands.hand_files import hand_in
from graspdsl.hands.mount_files import mount_in
from graspdsl.notation.parser import parse_definition, parse_head, parse_resource_definition
from graspdsl.notation.syntax import Start
from graspdsl.notation.tree import Expression, Head, Resources
from graspdsl.places.document import Document, Path
from graspdsl.places.files import SpecFolder, with_plain_line_ends
from graspdsl.places.folders import names_a_file
from graspdsl.plugins.kinds import OF_OTHERS
from graspdsl.spec.loading import read_document, spec_of
from graspdsl.spec.models import Spec

T = TypeVar("T")
Place = tuple[int, int]  # line and column, of characters, from 1


@dataclass(frozen=True, slots=True)
class Formula:
    """A formula of the spec, with the tree of one that can be read.

    ``entry``: the path of the controller that it is the head or the body of, and ``bound`` the names of that
    controller's own parameters; () and none for any other.
    """

    path: Path
    text: SourceText
    start: Start
    tree: Expression | Head | Resources | None
    entry: Path = ()
    bound: frozenset[str] = frozenset()

    @property
    def span(self) -> Span:
        """Where it stands."""
        return self.text.span(0, len(self.text.text))

    def index(self, place: Place) -> int | None:
        """Which of its characters stands at a place, or before which one it is; None for a place outside of it."""
        places = self.text.places
        if not places[0] <= place <= places[-1]:
            return None
        return bisect_left(places, place)


@dataclass(frozen=True, slots=True)
class Sheet:
    """A text as far as it could be read; ``formulas`` are those of resources, controllers and phases."""

    text: str
    document: Document
    spec: Spec
    declared: Declarations
    formulas: tuple[Formula, ...]
    definitions: Mapping[str, Definition]

    def formula_at(self, place: Place) -> Formula | None:
        """The formula that a place is in."""
        return next((formula for formula in self.formulas if formula.index(place) is not None), None)


def sheet_of(text: str) -> Sheet | None:
    """What can be read of a text; None where it is no YAML, or not that of a mapping."""
    return _sheet_of(with_plain_line_ends(text), tuple(OF_OTHERS))


@lru_cache(maxsize=8)
def _sheet_of(text: str, offered: tuple[str, ...]) -> Sheet | None:
    del offered  # controllers of other packages, which may have come since
    try:
        written = read_document(text, "spec.yaml")
    except DiagnosticError:
        return None
    reading = spec_of(written, known_names())
    declared = declarations_of(reading.spec, reading.document)
    definitions = definitions_with(declared.controllers, Complaints(), OF_OTHERS)
    return Sheet(text, reading.document, reading.spec, declared, _formulas(declared), definitions)


def _formulas(declared: Declarations) -> tuple[Formula, ...]:
    found = list[Formula]()
    for entry in declared.resources:
        if is_formula(entry.value.text):
            name, members = _tree(entry.value, parse_resource_definition) or (None, None)
            found.append(Formula(entry.path, entry.value, "resources", members))
            found += [Formula(entry.path, entry.value, "resources", name)] if name else []
    for entry in declared.controllers:
        whole = entry.path[:2]
        head = _tree(entry.key, parse_head)
        bound = frozenset(_bound(head))
        found.append(Formula(whole, entry.key, "head", head, whole, bound))
        again, body = _tree(entry.value, parse_definition) or (None, None)
        found.append(Formula(entry.path, entry.value, "expression", body, whole, bound))
        found += [Formula(entry.path, entry.value, "head", again, whole, bound)] if again else []
    for phase in declared.phases:
        _, run = _tree(phase.formula, parse_definition) or (None, None)
        found.append(Formula(phase.path, phase.formula, "expression", run))
    return tuple(found)


def _bound(head: Head | None) -> list[str]:
    if head is None:
        return []
    reference = () if head.reference is None else (head.reference,)
    return [name.text for name in (*head.effector, *head.sensor, *reference)]


def _tree(text: SourceText, parse: Callable[[SourceText], T]) -> T | None:
    try:
        return parse(text)
    except DiagnosticError:
        return None


def robot_of(spec: Spec, folder: FilePath) -> Robot | None:
    """The hand of a spec on its mount, those of files too; None where one of them cannot be read."""
    hand, mount = spec.scene.hand, spec.scene.mount
    if not isinstance(hand, str) or not isinstance(mount, str):
        return None
    found = _file(folder, hand, _hand) if names_a_file(hand) else hands().get(hand)
    carrier = _file(folder, mount, _mount) if names_a_file(mount) else mounts().get(mount)
    return None if found is None or carrier is None else Robot(hand=found, mount=carrier)


def _file(folder: FilePath, name: str, read: Callable[[str, str, float], T]) -> T | None:
    try:
        return read(str(folder), name, (folder / name).stat().st_mtime)
    except (DiagnosticError, DescriptionFileError, OSError, ValueError):
        return None


@lru_cache(maxsize=8)
def _hand(folder: str, name: str, written: float) -> Hand:
    del written  # a file that was written anew is read anew
    return hand_in(SpecFolder(FilePath(folder)), name).hand


@lru_cache(maxsize=8)
def _mount(folder: str, name: str, written: float) -> Mount:
    del written
    return mount_in(SpecFolder(FilePath(folder)), name).mount
