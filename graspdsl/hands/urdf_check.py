"""Elements of a URDF held against the rules: every fault with its place, and a copy with only what was checked."""

from __future__ import annotations

import re
from collections import Counter
from dataclasses import dataclass, field, replace
from pathlib import PurePosixPath
from xml.etree import ElementTree

import numpy as np

from graspdsl.diagnostics import Diagnostic, Severity, listed
from graspdsl.hands.urdf_rules import MESHES, SHAPES, ElementRule, NumberRule
from graspdsl.places.wording import as_yaml, shortened
from graspdsl.places.xml_files import place_in

NUMBER = re.compile(r"[+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?", re.ASCII)
COUNTS = {1: "a number", 3: "three numbers", 4: "four numbers"}
UNITS = {"m": "lengths are in metres", "rad": "angles are in radians", "kg": "masses are in kilograms"}
LONGEST_PATH = 1000  # characters
SMALLEST = 1e-9  # of the largest component of an axis, and of a scale


def undrawn(fault: Diagnostic, what: str) -> Diagnostic:
    """The warning of a fault in what is only drawn."""
    message = f"{fault.message}; {what}, and others like it, are not drawn"
    return replace(fault, code="undrawn", message=message, severity=Severity.WARNING)


@dataclass(slots=True)
class UrdfCheck:
    """Copies elements of a file, noting faults and warnings, and the names of links and joints with faults."""

    file: str
    found: list[Diagnostic] = field(default_factory=list)
    warnings: list[Diagnostic] = field(default_factory=list)
    unsound: set[str] = field(default_factory=set)
    _undrawn: set[tuple[str, str]] = field(default_factory=set)

    def part(self, name: str, element: ElementTree.Element, rule: ElementRule, owner: str) -> ElementTree.Element:
        """The copy of a link or a joint, by its name."""
        before = len(self.found)
        copied = self.copy(element, rule, owner)
        if len(self.found) > before:
            self.unsound.add(name)
        return copied

    def copy(self, element: ElementTree.Element, rule: ElementRule, owner: str) -> ElementTree.Element:
        """The element with only what its rule has; ``owner`` is what it belongs to, for messages."""
        copied = ElementTree.Element(element.tag)
        for key in rule.texts:
            copied.set(key, element.get(key, ""))
        before = len(self.found)
        for key, numbers in rule.numbers.items():
            values = self._numbers(element, key, numbers, owner)
            if values:
                copied.set(key, " ".join(map(repr, values)))
        self._stands_once(element, rule, owner)
        for child in element:
            inner = rule.children.get(child.tag)
            if inner is not None:
                copied.extend(self._drawn(child, inner, owner) if inner.drawn else [self.copy(child, inner, owner)])
        if len(self.found) == before:
            self._together(element, copied, owner)
        return copied

    def fault(self, element: ElementTree.Element, code: str, message: str, hint: str | None) -> None:
        """Note a fault at the place of an element."""
        self.found.append(Diagnostic(code, f"{place_in(self.file, element)}: {message}", hint=hint))

    def warn(self, element: ElementTree.Element, code: str, message: str, hint: str | None) -> None:
        """Note what is doubtful at the place of an element."""
        message = f"{place_in(self.file, element)}: {message}"
        self.warnings.append(Diagnostic(code, message, hint=hint, severity=Severity.WARNING))

    def _numbers(self, element: ElementTree.Element, key: str, wanted: NumberRule, owner: str) -> tuple[float, ...]:
        text = element.get(key, wanted.otherwise)
        if text == "" and key not in element.attrib:
            return ()
        words = (text or "").split()
        values = tuple(float(word) for word in words if NUMBER.fullmatch(word))
        right = len(values) == len(words) == wanted.count
        if right and all(
            wanted.lowest <= x <= wanted.highest and (x > wanted.lowest or not wanted.above) for x in values
        ):
            return values
        low, high = as_yaml(float(f"{wanted.lowest:.4g}")), as_yaml(float(f"{wanted.highest:.4g}"))
        bounds = f"above {low}, up to {high}" if wanted.above else f"from {low} to {high}"
        unit = f" ({wanted.unit})" if wanted.unit else ""
        found = "nothing" if text is None else repr(shortened(text))
        message = (
            f"{owner}: expected {COUNTS[wanted.count]} {bounds}{unit} as the {key} of <{element.tag}>, found {found}"
        )
        code = "out-of-range" if right else "not-a-number"
        hint = (
            UNITS.get(wanted.unit, "keep within these bounds") if right else "write finite numbers, blanks between them"
        )
        self.fault(element, code, message, hint)
        return ()

    def _stands_once(self, element: ElementTree.Element, rule: ElementRule, owner: str) -> None:
        if rule.only_one:
            shapes = [child.tag for child in element]
            if len(shapes) != 1 or shapes[0] not in rule.children:
                found = listed(f"<{shortened(tag)}>" for tag in shapes[:5]) or "none"
                message = f"{owner}: expected one shape in <{element.tag}>, found {found}"
                self.fault(element, "wrong-shape", message, f"known shapes: {', '.join(SHAPES)}")
            return
        counts = Counter(child.tag for child in element)
        for tag, count in counts.items():
            if count > 1 and tag in rule.children and tag not in rule.many:
                message = f"{owner}: expected one <{tag}> in <{element.tag}>, found {count}"
                self.fault(element.findall(tag)[1], "declared-twice", message, "keep one of them")
        missing = [f"<{tag}>" for tag in rule.needed if tag not in counts]
        if missing:
            message = f"{owner}: <{element.tag}> has no {listed(missing)}"
            self.fault(element, "missing-element", message, f"add {listed(missing)}")

    def _together(self, element: ElementTree.Element, copied: ElementTree.Element, owner: str) -> None:
        """What the numbers of one element must be to one another."""
        values = {key: np.array(text.split(), dtype=float) for key, text in copied.attrib.items() if key in OF_NUMBERS}
        if element.tag == "axis":
            length = float(np.linalg.norm(values["xyz"]))
            if length < SMALLEST:
                self.fault(
                    element, "zero-axis", f"{owner}: its axis is zero", 'give it a direction, such as xyz="0 0 1"'
                )
            else:
                copied.set("xyz", " ".join(repr(float(x)) for x in values["xyz"] / length))
        elif element.tag == "limit" and "lower" in values and values["lower"] > values["upper"]:
            low, high = float(values["lower"][0]), float(values["upper"][0])
            message = f"{owner}: its limits leave no room: {low:g} to {high:g}"
            self.fault(element, "out-of-range", message, "the lower limit must be below the upper one")
        elif element.tag == "mesh":
            before = len(self.found)
            self._mesh(element, values, owner)
            if len(self.found) > before:
                copied.set("filename", "")  # nobody need look for it

    def _drawn(self, element: ElementTree.Element, rule: ElementRule, owner: str) -> list[ElementTree.Element]:
        """The copy of an element that is only drawn; none, and a warning, when there is a fault in it."""
        before = len(self.found)
        copied = self.copy(element, rule, owner)
        faults = self.found[before:]
        del self.found[before:]
        if not faults:
            return [copied]
        fault = faults[0]
        kind = element.tag, fault.code
        if kind not in self._undrawn:
            self._undrawn.add(kind)
            self.warnings.append(undrawn(fault, f"this <{element.tag}>"))
        return []

    def _mesh(self, element: ElementTree.Element, values: dict[str, np.ndarray], owner: str) -> None:
        name = element.get("filename", "")
        if not name or len(name) > LONGEST_PATH:
            what = "names no file" if not name else "names a file of too long a path"
            self.fault(element, "missing-key", f"{owner}: its <mesh> {what}", 'write filename="part.stl"')
        elif PurePosixPath(name).suffix.lower() not in MESHES:
            message = f"{owner}: its <mesh> is of an unknown format: {shortened(name)!r}"
            self.fault(element, "unknown-mesh-format", message, f"convert it to {listed(MESHES, 'or')}")
        elif "scale" in values and not (np.abs(values["scale"]) > SMALLEST).all():
            self.fault(
                element, "out-of-range", f"{owner}: the scale of its <mesh> is zero", "write the size of a unit in m"
            )


OF_NUMBERS = ("xyz", "scale", "lower", "upper")
