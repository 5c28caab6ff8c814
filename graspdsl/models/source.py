"""The XML of a model on its way to the compiler: what is wrong with it, and where each element stands in the files."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from xml.etree import ElementTree

from graspdsl.diagnostics import Diagnostic, DiagnosticError, Severity
from graspdsl.places.wording import shortened
from graspdsl.places.xml_files import PlacedElement, place_in

MOST_FAULTS = 20  # that are told at once
LARGEST = 1e15  # of a number, of any unit
NAMES = frozenset({"name", "class", "childclass", "file", "filename", "model"})  # attributes that are no numbers


def place(element: ElementTree.Element) -> str:
    """``file:line:column`` of an element; empty of one that stands in no file."""
    return place_in(element.file, element) if isinstance(element, PlacedElement) else ""


@dataclass(slots=True)
class Complaints:
    """What is wrong with a model, and what is only doubtful."""

    faults: list[Diagnostic] = field(default_factory=list)
    warnings: list[Diagnostic] = field(default_factory=list)
    _undrawn: set[str] = field(default_factory=set)

    def fault(self, where: ElementTree.Element | str, code: str, message: str, hint: str | None) -> None:
        """Note what is wrong at a place."""
        self.faults.append(Diagnostic(code, _told(where, message), hint=hint))

    def warn(self, where: ElementTree.Element | str, code: str, message: str, hint: str | None) -> None:
        """Note what is doubtful at a place."""
        self.warnings.append(Diagnostic(code, _told(where, message), hint=hint, severity=Severity.WARNING))

    def undrawn(self, fault: Diagnostic) -> None:
        """Note that what is only drawn is left out: of each kind of fault the first."""
        if fault.code not in self._undrawn:
            message = f"{fault.message}; this, and others like it, are not drawn"
            self.warnings.append(replace(fault, code="undrawn", message=message, severity=Severity.WARNING))
        self._undrawn.add(fault.code)

    def refuse(self) -> None:
        """Raises DiagnosticError with all faults, where there are any."""
        if self.faults:
            raise DiagnosticError(self.faults[:MOST_FAULTS])


def _told(where: ElementTree.Element | str, message: str) -> str:
    at = where if isinstance(where, str) else place(where)
    return f"{at}: {message}" if at else message


@dataclass(frozen=True, slots=True)
class Prepared:
    """What the compiler is given: the text of a file, the element of each of its lines, those of bodies, joints, geoms
    and others by their kind and name, and those of mesh files by the names that stand for them in the text."""

    file: str
    text: str
    lines: tuple[ElementTree.Element, ...]
    elements: Mapping[tuple[str, str], ElementTree.Element]
    meshes: Mapping[str, ElementTree.Element]

    def place(self, kind: str, name: str) -> str:
        """Where a part of that kind and name stands, the file where it has no place of its own."""
        element = self.elements.get((kind, name))
        return (place(element) if element is not None else "") or self.file


def prepared(file: str, tree: ElementTree.Element, meshes: Mapping[str, ElementTree.Element]) -> Prepared:
    """A tree of elements as text, one tag a line, so that a line of it is an element of a file."""
    lines: list[str] = []
    elements: list[ElementTree.Element] = []

    def write(element: ElementTree.Element) -> None:
        from xml.sax.saxutils import quoteattr  # which brings a web client along

        attributes = (f" {key}={quoteattr(value)}" for key, value in element.attrib.items() if _is_plain(key))
        lines.append(f"<{element.tag}{''.join(attributes)}>")
        elements.append(element)
        for child in element:
            if _is_plain(child.tag):
                write(child)
        lines.append(f"</{element.tag}>")
        elements.append(element)

    write(tree)
    named = {(KINDS.get(found.tag, found.tag), found.get("name", "")): found for found in elements if found.get("name")}
    return Prepared(file, "\n".join(lines), tuple(elements), named, meshes)


def _is_plain(name: str) -> bool:
    """Whether a name is none of another program's, which have a prefix."""
    return "}" not in name and ":" not in name


KINDS = {"link": "body", "visual": "geom", "collision": "geom", "freejoint": "joint"}


def check_numbers(tree: ElementTree.Element, complaints: Complaints) -> None:
    """Complain about numbers that are none, or that nothing is measured by, wherever they stand."""
    for element in tree.iter():
        for key, text in element.attrib.items():
            if key not in NAMES and not all(map(_moderate, text.split())):
                message = f"the {key} of <{element.tag}> is {shortened(text)!r}"
                hint = f"write finite numbers, none beyond {LARGEST:g}"
                complaints.fault(element, "not-a-number", message, hint)


def _moderate(word: str) -> bool:
    """Whether a word is a number of moderate size, or none at all."""
    try:
        return abs(float(word)) <= LARGEST
    except ValueError:
        return True


def is_number(word: str) -> bool:
    """Whether a word is a finite number of moderate size."""
    try:
        return math.isfinite(float(word)) and word.isascii() and "_" not in word
    except ValueError:
        return False
