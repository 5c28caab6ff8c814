"""The one reader of XML that others wrote: bounded, without document types, every element with its place."""

from __future__ import annotations

import codecs
from collections.abc import Mapping
from xml.etree import ElementTree
from xml.parsers import expat

from graspdsl.places.files import refusal
from graspdsl.places.wording import shortened

LARGEST = 1024 * 1024  # bytes
MOST_ELEMENTS = 50_000
DEEPEST = 200
PLAIN = "utf-8"
# What may be declared, by the name of its codec, as the parser calls it: others can stand for a codec that runs code of
# its own, or that expands.
ENCODINGS: Mapping[str, str] = {
    "utf-8": "utf-8",
    "utf-16": "utf-16",
    "ascii": "us-ascii",
    "iso8859-1": "iso-8859-1",
    "cp1252": "windows-1252",
}


class PlacedElement(ElementTree.Element):
    """An element that knows the file it stands in and where its tag begins, line and column from 1."""

    file = ""
    line = 0
    column = 0


def xml_tree(content: bytes, name: str) -> PlacedElement:
    """The root of the elements of an XML file, with their attributes and without their texts.

    Raises DiagnosticError for a file that is too large, too deep, no XML, in an unknown encoding, or that declares a
    document type, and with it entities that may expand without end.
    """
    if len(content) > LARGEST:
        message = f"{name} is too large: {len(content)} bytes, where an XML file may have {LARGEST}"
        raise refusal("file-too-large", message, "leave out what is not needed; meshes stand in files of their own")
    encoding: str | None = None
    separator: str | None = "}"
    while True:
        try:
            return _Reading(name, encoding, separator).read(content)
        except _OtherNameError as error:
            encoding = error.encoding
        except _OtherPrefixError:
            separator = None


def place_in(name: str, element: ElementTree.Element) -> str:
    """``file:line:column`` of an element, only the file's name for one that was not read from it."""
    return f"{name}:{element.line}:{element.column}" if isinstance(element, PlacedElement) and element.line else name


class _OtherNameError(Exception):
    """A file declares its encoding by a name that the parser does not know, or not well."""

    def __init__(self, encoding: str) -> None:
        self.encoding = encoding
        super().__init__(encoding)


class _OtherPrefixError(Exception):
    """A file has a prefix that it does not declare, as elements for other programs have."""


class _Reading:
    """One reading of a file, in an encoding of the parser or in that which the file declares."""

    def __init__(self, name: str, encoding: str | None, separator: str | None) -> None:
        self._name, self._encoding = name, encoding
        self._open: list[PlacedElement] = []
        self._root: PlacedElement | None = None
        self._count = 0
        self._parser = expat.ParserCreate(encoding, namespace_separator=separator)
        self._parser.XmlDeclHandler = self._declared
        self._parser.StartDoctypeDeclHandler = self._doctype
        self._parser.StartElementHandler = self._start
        self._parser.EndElementHandler = self._end

    def read(self, content: bytes) -> PlacedElement:
        try:
            self._parser.Parse(content, True)
        except expat.ExpatError as error:
            if error.code == expat.errors.codes[expat.errors.XML_ERROR_UNBOUND_PREFIX]:
                raise _OtherPrefixError from None
            reason = expat.ErrorString(error.code)
            message = f"{self._name} is no XML: line {error.lineno}, column {error.offset + 1}: {reason}"
            raise refusal("bad-xml", message, "mend it there") from None
        except (LookupError, ValueError) as error:
            raise refusal("bad-xml", f"{self._name} is no XML: {error}", f"write it in {PLAIN}") from None
        assert self._root is not None
        return self._root

    def _declared(self, _version: str, encoding: str | None, _standalone: int) -> None:
        if encoding is None or self._encoding is not None:
            return
        try:
            known = ENCODINGS[codecs.lookup(encoding).name]
        except LookupError:
            message = f"{self._name} is in an unknown encoding, {shortened(encoding)!r}"
            raise refusal("bad-xml", message, f"write it in {PLAIN}") from None
        if encoding.lower() != known:
            raise _OtherNameError(known)

    def _doctype(self, *_declaration: object) -> None:
        message = f"{self._here()}: the file declares a document type, which no robot needs"
        raise refusal("bad-xml", message, "leave the <!DOCTYPE …> out")

    def _start(self, tag: str, attributes: dict[str, str]) -> None:
        element = PlacedElement(_whole(tag), {_whole(key): text for key, text in attributes.items()})
        element.file = self._name
        element.line, element.column = self._parser.CurrentLineNumber, self._parser.CurrentColumnNumber + 1
        self._count += 1
        if self._count > MOST_ELEMENTS or len(self._open) >= DEEPEST:
            what = f"has more than {MOST_ELEMENTS} elements" if self._count > MOST_ELEMENTS else "is nested too deeply"
            raise refusal("file-too-large", f"{self._here()}: the file {what}", "simplify it")
        if self._open:
            self._open[-1].append(element)
        else:
            self._root = element
        self._open.append(element)

    def _end(self, _tag: str) -> None:
        self._open.pop()

    def _here(self) -> str:
        return f"{self._name}:{self._parser.CurrentLineNumber}:{self._parser.CurrentColumnNumber + 1}"


def _whole(name: str) -> str:
    """A name as ElementTree writes it, its namespace in braces."""
    return f"{{{name}" if "}" in name else name
