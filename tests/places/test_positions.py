"""Properties: characters land where they stand, and no input brings anything but diagnostics."""

from __future__ import annotations

import string

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from graspdsl.diagnostics import DiagnosticError, SourceText
from graspdsl.places.document import Document, parse_document

WORD = st.text(alphabet="πφστγΓκ_|(){}<>◁,1x\"'\\", min_size=1, max_size=8)
WORDS = st.lists(WORD, min_size=1, max_size=6)
GAPS = st.lists(st.sampled_from([" ", "  ", "break", "blank"]), min_size=6, max_size=6)


class Writer:
    """Writes a YAML file and notes where each character of a scalar's value goes."""

    def __init__(self, head: str) -> None:
        self.text = head
        self.value = ""
        self.places: list[tuple[int, int]] = []

    def here(self) -> tuple[int, int]:
        return self.text.count("\n") + 1, len(self.text) - (self.text.rfind("\n") + 1) + 1

    def put(self, value: str, written: str) -> None:
        """A character of the value, and what stands for it in the file."""
        self.value += value
        self.places.append(self.here())
        self.text += written

    def gap(self, kind: str, indent: str) -> None:
        """What stands between two words where line breaks fold: a break for a blank, a blank line for a break."""
        if kind == "break":
            self.put(" ", "\n" + indent)
        elif kind == "blank":
            self.text += "\n"
            self.put("\n", "\n" + indent)
        else:
            for blank in kind:
                self.put(blank, blank)

    def check(self, end: str = "") -> None:
        for tail in ("", "\n", "\nother: 1\n"):
            document = parse_document(self.text + end + tail, "test.yaml")
            source = document.source_text(("p", 0, "run"))
            assert source.text == self.value
            assert source.places == (*self.places, source.places[-1])
            assert source.places[-1] >= self.places[-1]


def plain(word: str) -> str:
    """The word made fit to begin or go on a plain scalar."""
    return "π" + word.replace("'", "").replace('"', "") + "x"


@pytest.mark.slow
@given(WORDS, GAPS, st.sampled_from(["", "&a ", "!!str ", "&a # why\n      "]))
def test_plain(words: list[str], gaps: list[str], before: str) -> None:
    writer = Writer(f"Γ: 1\np:\n  - run: {before}")
    for number, word in enumerate(words):
        if number:
            writer.gap(gaps[number - 1], "      ")
        for character in plain(word):
            writer.put(character, character)
    writer.check()


@pytest.mark.slow
@given(WORDS, GAPS)
def test_single_quoted(words: list[str], gaps: list[str]) -> None:
    writer = Writer("Γ: 1\np:\n  - {run: '")
    for number, word in enumerate(words):
        if number:
            writer.gap(gaps[number - 1], "     ")
        for character in word:
            writer.put(character, "''" if character == "'" else character)
    writer.check("'}")


@pytest.mark.slow
@given(WORDS, GAPS, st.data())
def test_double_quoted(words: list[str], gaps: list[str], data: st.DataObject) -> None:
    writer = Writer('p:\n- run: "')
    for number, word in enumerate(words):
        if number:
            writer.gap(gaps[number - 1], "   ")
        for place, character in enumerate(word):
            if place and data.draw(st.booleans()):
                writer.text += "\\\n     "  # an escaped line break stands for nothing
            spellings = [f"\\u{ord(character):04x}", f"\\U{ord(character):08X}"]
            spellings.append("\\" + character if character in '"\\' else character)
            writer.put(character, data.draw(st.sampled_from(spellings)))
    writer.check('"')


@pytest.mark.slow
@given(st.lists(WORDS, min_size=1, max_size=4), st.sampled_from(["|", "|-", "|+", "|1", "&a |", "| # why"]))
def test_literal(rows: list[list[str]], header: str) -> None:
    # With the indentation said to be one more than that of the mapping, one of the four blanks belongs to the text.
    indent = "   " if header == "|1" else "    "
    writer = Writer(f"p:\n- run: {header}\n{indent}")
    for number, words in enumerate(rows):
        if number:
            writer.put("\n", "\n" + indent)
        for character in "    "[len(indent) :] + " ".join(words):
            writer.put(character, character)
    source = parse_document(writer.text, "test.yaml").source_text(("p", 0, "run"))
    assert source.text == writer.value
    assert source.places[:-1] == tuple(writer.places)


@pytest.mark.slow
@given(WORDS, GAPS)
def test_folded(words: list[str], gaps: list[str]) -> None:
    writer = Writer("p:\n  - run: >-\n      ")
    for number, word in enumerate(words):
        if number:
            writer.gap(gaps[number - 1], "      ")
        for character in word:
            writer.put(character, character)
    writer.check()


def test_block_scalars_with_lines_of_their_own_indentation() -> None:
    text = "a: >+\n\n   one\n    two\n    three\n   \n   four\n\n\nb: |1\n   x\n\n  y\n"
    document = parse_document(text, "test.yaml")
    folded, literal = document.source_text(("a",)), document.source_text(("b",))
    assert (folded.text, literal.text) == ("\none\n two\n three\n\nfour\n\n\n", "  x\n\n y\n")
    assert folded.places[0] == (2, 1)
    assert folded.places[folded.text.index("four")] == (7, 4)
    assert literal.places[0] == (11, 2)
    assert literal.places[literal.text.index("y")] == (13, 3)


def scalars(document: Document) -> list[SourceText]:
    """The source texts of all scalars and keys."""
    found = []
    for path, place in document.places.items():
        if place.value.value is not None:
            found.append(document.source_text(path))
        if place.key is not None:
            found.append(document.key_source_text(path))
    return found


def places(text: str) -> list[tuple[int, int]]:
    """Every place that a document, or else the complaints about it, name."""
    try:
        document = parse_document(text, "test.yaml")
    except DiagnosticError as error:
        return [(d.span.line, d.span.column) for d in error.diagnostics if d.span is not None]
    sources = scalars(document)
    assert all(len(source.places) == len(source.text) + 1 for source in sources)
    return [place for source in sources for place in source.places]


def hold(text: str) -> None:
    """Reads any text: every place that comes of it lies inside it."""
    rows = text.removeprefix("\ufeff").replace("\r\n", "\n").replace("\r", "\n").split("\n")
    for line, column in places(text):
        assert 1 <= line <= len(rows)
        assert 1 <= column <= len(rows[line - 1]) + 1


SIGNS = [
    *string.punctuation,
    *"aγ1 \n\t",
    "  ",
    "\n  ",
    "\n- ",
    ": ",
    "a: ",
    "- ",
    "*a",
    "&a ",
    "<<: ",
    "!!str ",
    "0x",
    "%TAG",
]


@pytest.mark.slow
@settings(max_examples=400)
@given(st.lists(st.sampled_from(SIGNS), max_size=40).map("".join))
def test_no_text_of_yaml_signs_breaks_the_reader(text: str) -> None:
    hold(text)
    hold("a: " + text)


@given(st.text(alphabet=st.characters(), max_size=60))
def test_no_text_breaks_the_reader(text: str) -> None:
    hold(text)


@given(st.text(alphabet="\\xuUN0123456789abefL_P \n\t'", max_size=30))
def test_no_escape_breaks_the_reader(text: str) -> None:
    hold(f'a: "{text}"')


@given(st.text(alphabet="|>+-0129 \nab#:\t", max_size=40))
def test_no_block_scalar_breaks_the_reader(text: str) -> None:
    hold(f"a:\n  b: |{text}")
    hold(f"a:\n  b: >{text}")
