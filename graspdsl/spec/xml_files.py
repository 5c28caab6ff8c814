"""The one reader of XML that others wrote: bounded, without document types, every element with its place."""

from __future__ import annotations

from xml.etree import ElementTree
from xml.parsers import expat

from graspdsl.spec.named_files import refusal
from graspdsl.spec.wording import shortened

LARGEST = 1024 * 1024  # bytes
MOST_ELEMENTS = 50_000
DEEPEST = 200
# What may be declared: others can stand for a codec that runs code of its own, or that expands.
ENCODINGS = ("utf-8", "utf-16", "us-ascii", "iso-8859-1", "windows-1252")


class PlacedElement(ElementTree.Element):
    """An element that knows where its tag begins, line and column from 1."""

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
    return _Reading(name).read(content)


def place_in(name: str, element: ElementTree.Element) -> str:
    """``file:line:column`` of an element, only the file's name for one that was not read from it."""
    line = element.line if isinstance(element, PlacedElement) else 0
    return f"{name}:{line}:{element.column}" if line and isinstance(element, PlacedElement) else name


class _Reading:
    def __init__(self, name: str) -> None:
        self._name = name
        self._open: list[PlacedElement] = []
        self._root: PlacedElement | None = None
        self._count = 0
        self._parser = expat.ParserCreate(namespace_separator="}")
        self._parser.XmlDeclHandler = self._declared
        self._parser.StartDoctypeDeclHandler = self._doctype
        self._parser.StartElementHandler = self._start
        self._parser.EndElementHandler = self._end

    def read(self, content: bytes) -> PlacedElement:
        try:
            self._parser.Parse(content, True)
        except expat.ExpatError as error:
            reason = expat.ErrorString(error.code)
            message = f"{self._name} is no XML: line {error.lineno}, column {error.offset + 1}: {reason}"
            raise refusal("bad-xml", message, "mend it there") from None
        except (LookupError, ValueError) as error:
            raise refusal("bad-xml", f"{self._name} is no XML: {error}", f"write it in {ENCODINGS[0]}") from None
        assert self._root is not None
        return self._root

    def _declared(self, _version: str, encoding: str | None, _standalone: int) -> None:
        if encoding is not None and encoding.lower() not in ENCODINGS:
            message = f"{self._name} is in an unknown encoding, {shortened(encoding)!r}"
            raise refusal("bad-xml", message, f"write it in {ENCODINGS[0]}")

    def _doctype(self, *_declaration: object) -> None:
        message = f"{self._here()}: the file declares a document type, which no robot needs"
        raise refusal("bad-xml", message, "leave the <!DOCTYPE …> out")

    def _start(self, tag: str, attributes: dict[str, str]) -> None:
        element = PlacedElement(_whole(tag), {_whole(key): text for key, text in attributes.items()})
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
