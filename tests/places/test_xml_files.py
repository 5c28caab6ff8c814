"""The reader of XML: places of elements, and every kind of file that it refuses, at once."""

from __future__ import annotations

import time
from xml.etree import ElementTree

import pytest

from graspdsl.diagnostics import DiagnosticError
from graspdsl.places.xml_files import DEEPEST, LARGEST, MOST_ELEMENTS, place_in, xml_tree

BOMB = "<!DOCTYPE r [<!ENTITY a 'aaaaaaaaaa'>" + "".join(
    f"<!ENTITY {chr(98 + i)} '{f'&{chr(97 + i)};' * 10}'>" for i in range(12)
)
BOMB = f"<?xml version='1.0'?>{BOMB}]><r>&m;</r>"
OUTSIDE = "<!DOCTYPE r [<!ENTITY a SYSTEM 'file:///etc/hostname'>]><r>&a;</r>"

REFUSED = {
    "entity bomb": (BOMB.encode(), "bad-xml", "the file declares a document type"),
    "entity bomb in another encoding": (BOMB.encode("utf-16"), "bad-xml", "declares a document type"),
    "another file": (OUTSIDE.encode(), "bad-xml", "declares a document type"),
    "another grammar": (b'<!DOCTYPE r SYSTEM "http://localhost/r.dtd"><r/>', "bad-xml", "declares a document type"),
    "unknown encoding": (b"<?xml version='1.0' encoding='wide'?><r/>", "bad-xml", "in an unknown encoding, 'wide'"),
    "codec of another kind": (b"<?xml version='1.0' encoding='hex'?><r/>", "bad-xml", "in an unknown encoding, 'hex'"),
    "other bytes": (b"<?xml version='1.0' encoding='utf-8'?><r a='\xff'/>", "bad-xml", "line 1, column 45"),
    "other width": (b"<?xml version='1.0' encoding='utf-16'?><r/>", "bad-xml", "line 1, column 31"),
    "entity without a type": (b"<r>\n &a;</r>", "bad-xml", "line 2, column 2: undefined entity"),
    "empty": (b"", "bad-xml", "no element found"),
    "binary": (bytes(range(256)), "bad-xml", "line 1, column 1"),
    "cut short": (b"<r><a>", "bad-xml", "line 1, column 7"),
    "two roots": (b"<r/><r/>", "bad-xml", "line 1, column 5"),
    "large": (b"<r>" + b" " * LARGEST + b"</r>", "file-too-large", "where an XML file may have 1048576"),
    "deep": (b"<a>" * 100_000, "file-too-large", f"robot.xml:1:{1 + 3 * DEEPEST}: the file is nested too deeply"),
    "many": (b"<a>" + b"<b/>" * MOST_ELEMENTS + b"</a>", "file-too-large", "more than 50000 elements"),
}


@pytest.mark.slow
@pytest.mark.parametrize("case", REFUSED)
def test_what_is_refused_is_refused_at_once(case: str) -> None:
    content, code, said = REFUSED[case]
    began = time.perf_counter()
    with pytest.raises(DiagnosticError) as caught:
        xml_tree(content, "robot.xml")
    assert time.perf_counter() - began < 2.0
    (fault,) = caught.value.diagnostics
    assert fault.code == code
    assert said in fault.message
    assert fault.hint


def test_elements_for_other_programs_are_read() -> None:
    assert [element.tag for element in xml_tree(b"<r><x:a/><b/></r>", "robot.xml")] == ["x:a", "b"]


@pytest.mark.parametrize(
    "encoding",
    [
        *("utf-8", "utf8", "UTF8", "utf_8", "utf-16", "UTF16", "iso-8859-1", "latin-1", "latin1", "ISO8859-1"),
        *("windows-1252", "cp1252"),
    ],
)
def test_elements_know_their_places(encoding: str) -> None:
    text = f"<?xml version='1.0' encoding='{encoding}'?>\n<robot name='é'>\n  <é/><link name='a'/></robot>"
    tree = xml_tree(text.encode(encoding), "robot.xml")
    assert tree.get("name") == "é"
    assert place_in("robot.xml", tree) == "robot.xml:2:1"
    assert place_in("robot.xml", tree[1]) == "robot.xml:3:7"


@pytest.mark.parametrize("encoding", ["us-ascii", "US-ASCII", "ascii", "ASCII", "utf8", "latin-1", "utf-16", "utf16"])
def test_what_the_writer_of_the_standard_library_declares(encoding: str) -> None:
    written = ElementTree.tostring(ElementTree.Element("robot", name="é"), encoding, xml_declaration=True)
    assert xml_tree(written, "robot.xml").get("name") == "é"


@pytest.mark.parametrize(
    "encoding", ["rot13", "idna", "unicode_escape", "utf-7", "utf-32", "utf-8-sig", "no.such", "."]
)
def test_other_codecs_are_unknown(encoding: str) -> None:
    with pytest.raises(DiagnosticError) as caught:
        xml_tree(f"<?xml version='1.0' encoding='{encoding}'?><r/>".encode(), "robot.xml")
    assert [fault.code for fault in caught.value.diagnostics] == ["bad-xml"]


def test_a_file_is_in_the_encoding_that_it_declares_by_another_name() -> None:
    for encoding in ("utf8", "ascii"):
        with pytest.raises(DiagnosticError) as caught:
            xml_tree(f"<?xml version='1.0' encoding='{encoding}'?><r a='".encode() + b"\xe9'/>", "robot.xml")
        assert "line 1, column" in caught.value.diagnostics[0].message


def test_namespaces_are_spelt_out() -> None:
    tree = xml_tree(b"<robot xmlns:x='http://x'><x:macro x:name='a'/></robot>", "robot.xml")
    assert (tree[0].tag, tree[0].attrib) == ("{http://x}macro", {"{http://x}name": "a"})
