"""Classes of defaults in MJCF: what an element says that it does not say itself."""

from __future__ import annotations

from collections.abc import Mapping
from xml.etree import ElementTree

from graspdsl.diagnostics import known_names_hint
from graspdsl.hands.mjcf_known import whole
from graspdsl.hands.mjcf_parts import ORIENTATIONS, Attributes, Part, Source

MAIN = "main"
QUATERNION = "quat"


class Defaults:
    """The classes of a file. A class begins as that about it; the one about all is called main and goes for all."""

    def __init__(self, source: Source, tree: ElementTree.Element) -> None:
        self._source = source
        self._classes: dict[str, Mapping[str, Attributes]] = {MAIN: {}}
        for default in tree.findall("default"):
            name = default.get("class", MAIN)
            with source.noting():
                whole(source, default)
                if name != MAIN:
                    message = f"the outermost class of defaults is called {name!r}"
                    raise source.refused(default, message, f"call it main, or put it within another <default>: {MAIN}")
            self._read(default, MAIN, self._classes[MAIN])
            self._classes[name] = self._classes[MAIN]

    def part(self, element: ElementTree.Element, inherited: str) -> Part:
        """An element with the attributes of its class, or of the one that the bodies about it give it.

        Raises DiagnosticError for a class that is not there, and for an attribute that is not read.
        """
        name = element.get("class", inherited)
        self.check(element, name)
        return whole(self._source, element, self._merged(self._classes[name].get(element.tag, {}), element))

    def check(self, element: ElementTree.Element, name: str) -> None:
        """Raises DiagnosticError where an element names a class that is not there."""
        if name not in self._classes:
            message = f"there is no class of defaults {name!r}"
            raise self._source.refused(element, message, known_names_hint(name, self._classes, "classes"))

    def _read(self, default: ElementTree.Element, name: str, above: Mapping[str, Attributes]) -> None:
        found = {**above}
        for element in default:
            if element.tag != "default":
                found[element.tag] = self._merged(found.get(element.tag, {}), element)
        self._classes[name] = found
        for inner in default.findall("default"):
            inner_name = inner.get("class", "")
            with self._source.noting():
                whole(self._source, inner)
                if not inner_name or inner_name in self._classes:
                    what = (
                        f"there is a class of defaults {inner_name!r} already" if inner_name else "a class has no name"
                    )
                    raise self._source.refused(inner, what, "give each class of defaults its own name")
            self._read(inner, inner_name, found)

    def _merged(self, above: Attributes, element: ElementTree.Element) -> dict[str, str]:
        own = element.attrib
        turned = any(key in own for key in ORIENTATIONS)
        other = next((key for key in ORIENTATIONS if key in above and key != QUATERNION), None)
        if QUATERNION in own and other is not None:
            # Older versions of MuJoCo (3.1) go by the class, newer ones (4.0) by the element.
            message = (
                f"<{element.tag}> has a quat and its class a {other}: MuJoCo keeps one or the other by its version"
            )
            with self._source.noting():
                raise self._source.refused(element, message, f"write it as {other}, or the class as quat")
        found = {key: value for key, value in above.items() if not (turned and key in ORIENTATIONS)} | own
        if "size" in above and "size" in own:
            # Sizes that an element does not say stay as they were.
            sizes = own["size"].split()
            found["size"] = " ".join(sizes + above["size"].split()[len(sizes) :])
        return found
