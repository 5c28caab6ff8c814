"""YAML text to data: what is read as what, and what is refused where and in which words."""

from __future__ import annotations

import pytest

from graspdsl.diagnostics import DiagnosticError, Span
from graspdsl.places.document import Document, parse_document


def faults(text: str) -> list[tuple[str, str, str]]:
    """(code, place, message) of every complaint about a text."""
    with pytest.raises(DiagnosticError) as caught:
        parse_document(text, "test.yaml")
    return [(d.code, f"{d.span.line}:{d.span.column}" if d.span else "-", d.message) for d in caught.value.diagnostics]


@pytest.mark.parametrize(
    ("scalar", "value"),
    [
        ("1e-3", 0.001),
        ("1e5", 100000.0),
        ("-.5", -0.5),
        ("2.", 2.0),
        (".inf", float("inf")),
        ("-.INF", float("-inf")),
        ("010", 10),
        ("0o17", 15),
        ("0x1F", 31),
        ("+3", 3),
        ("yes", "yes"),
        ("off", "off"),
        ("1:30", "1:30"),
        ("1_000", "1_000"),
        ("nan", "nan"),
        ("2026-01-02", "2026-01-02"),
        ("true", True),
        ("~", None),
        ("", None),
        ("'58'", "58"),
        ("!!str 58", "58"),
        ("! 58", "58"),
        ("π_s|Γ Γ (π_gx|Γ Γ)", "π_s|Γ Γ (π_gx|Γ Γ)"),
        ("φ_fr|τ_fr({γ1, γ2}) σ_fr(<γ1,γ2>)", "φ_fr|τ_fr({γ1, γ2}) σ_fr(<γ1,γ2>)"),
    ],
)
def test_scalars_follow_yaml_1_2(scalar: str, value: object) -> None:
    read = parse_document(f"a: {scalar}\n", "test.yaml").data["a"]
    assert read == value
    assert type(read) is type(value)


def test_nan_is_a_number() -> None:
    read = parse_document("a: .nan", "test.yaml").data["a"]
    assert isinstance(read, float)
    assert read != read


@pytest.mark.parametrize(
    ("text", "code", "place", "message"),
    [
        ("", "empty-file", "-", "there is nothing in this file"),
        ("# only a comment\n", "empty-file", "-", "there is nothing in this file"),
        ("--- \n...\n", "empty-file", "-", "there is nothing in this file"),
        ("hello", "not-a-mapping", "1:1", "expected keys with values, found the text 'hello'"),
        ("# a\n- a\n- b", "not-a-mapping", "2:1", "expected keys with values, found a list"),
        ("a: 1\n---\nb: 2", "several-documents", "2:1", "a second YAML document begins here"),
        (
            "a: 1\nb: 2\na: 3",
            "duplicate-key",
            "3:1",
            "the key 'a' stands here for the second time; the first is on line 1",
        ),
        ("a: !!python/object:os.system x", "unknown-tag", "1:4", "the tag !!python/object:os.system cannot stand here"),
        ("a: !mine {b: 1}", "unknown-tag", "1:4", "the tag !mine cannot stand here"),
        ("%TAG ! in\n---\na: !t abc", "unknown-tag", "3:4", "the tag int cannot stand here"),
        ("a:\n\tb: 1", "tab-indentation", "2:1", "a tab cannot indent YAML"),
        ("a: \tb", "tab", "1:4", "a tab cannot stand here"),
        ("a: &x [*x]", "recursive-anchor", "1:4", "this anchor contains itself"),
        ("a: &x\n  b: {c: *x}\n", "recursive-anchor", "1:4", "this anchor contains itself"),
        ("a: &x\n  <<: *x\n", "recursive-anchor", "1:4", "this anchor contains itself"),
        ("a: *x", "unknown-alias", "1:4", "there is no anchor for *x"),
        ("a: {<<: 3}", "bad-merge", "1:5", "'<<' takes a mapping, or a list of mappings, to take keys from"),
        ("1: x", "key-not-text", "1:1", "YAML reads the key '1' as a number, not as text"),
        ("? [a]\n: b", "key-not-text", "1:3", "YAML reads this as a list, and a list cannot be a key"),
        ("a: 'b", "open-quote", "1:4", "this ' is never closed"),
        ('a: "b" c', "text-after-value", "1:8", "nothing may follow the closing quote, but 'c' does"),
        ('a: "\\phi|b"', "bad-escape", "1:5", "'\\p' means nothing in double quotes, so that this is no \\phi"),
        ('a: "\\d|b"', "bad-escape", "1:5", "'\\d' means nothing in double quotes"),
        (
            'a: "\\UFFFFFFFF"',
            "bad-escape",
            "1:7",
            "there is no character with this number, or the number is too long",
        ),
        ('a: "\\e[31m"', "bad-character", "1:5", "the text holds the control character U+001B"),
        ('a: "\\ud83d"', "bad-character", "1:5", "the text holds the control character U+D83D"),
        ("a: b\0", "bad-character", "1:5", "the character U+0000 cannot stand in a YAML file"),
        ("a: b\u2028c", "bad-character", "1:5", "the character U+2028 (line separator) cannot stand in a YAML file"),
        ("a: [1, 2\nb: 3", "open-bracket", "1:4", "this '[' is not closed"),
        ("a: {γ1, <γ2", "open-bracket", "1:4", "this '{' is not closed"),
        ("a: [", "open-bracket", "1:4", "this '[' is not closed"),
        ("a: 1\n]", "yaml-syntax", "2:1", "this ']' closes nothing"),
        ("a: }", "yaml-syntax", "1:4", "a value cannot begin with '}'"),
        ("a: 1\nfoo\nb: 2", "no-key", "2:1", "this is no 'key: value': 'foo'"),
        ("name:foo\nx: 1", "no-key", "2:1", "the line above is no 'key: value': 'name:foo'"),
        (
            "a: 1\n  b: 2",
            "bad-indentation",
            "2:3",
            "this line is indented deeper than the line above, which already has a value",
        ),
        (
            "a:\n    b: 1\n  c: 2\n",
            "bad-indentation",
            "3:3",
            "this line does not belong to the block that begins on line 1",
        ),
        ("a: - b", "misplaced-item", "1:4", "a list item cannot begin here"),
        (f"a: {'9' * 5000}", "number-too-long", "1:4", "this number has 5000 characters"),
        (f"a: {'[' * 100}", "too-deep", "1:43", "lists and mappings are nested more than 40 levels deep here"),
    ],
)
def test_faulty_text(text: str, code: str, place: str, message: str) -> None:
    assert faults(text) == [(code, place, message)]


@pytest.mark.parametrize(
    ("text", "place", "hint"),
    [
        ("run: π_s|Γ Γ: x", "1:6", 'put the text in quotes: "π_s|Γ Γ: x"'),
        ("p:\n  - run: φ|τ({γ1}) σ: (1)", "2:10", 'put the text in quotes: "φ|τ({γ1}) σ: (1)"'),
        ("run: |Γ Γ", "1:6", 'put the text in quotes: "|Γ Γ"'),
        ("run: >γ2", "1:6", 'put the text in quotes: ">γ2"'),
        ("Γ: {γ1} ∪ {γ2}", "1:4", 'put the text in quotes: "{γ1} ∪ {γ2}"'),
        ("run: @Γ", "1:6", 'put the text in quotes: "@Γ"'),
        ("run: `Γ`", "1:6", 'put the text in quotes: "`Γ`"'),
        ("run: * \\phi", "1:6", "put the text in quotes: '* \\phi'"),
    ],
)
def test_a_formula_without_its_quotes_is_shown_with_them(text: str, place: str, hint: str) -> None:
    with pytest.raises(DiagnosticError) as caught:
        parse_document(text, "test.yaml")
    [diagnostic] = caught.value.diagnostics
    assert diagnostic.span is not None
    assert (diagnostic.code, f"{diagnostic.span.line}:{diagnostic.span.column}", diagnostic.hint) == (
        "unquoted-text",
        place,
        hint,
    )


def test_a_nested_set_without_quotes_is_shown_with_them() -> None:
    with pytest.raises(DiagnosticError) as caught:
        parse_document("Γ: {{γ1,γ2}, γ3}", "test.yaml")
    assert [d.hint for d in caught.value.diagnostics] == ['a set of resources needs quotes: "{{γ1,γ2}, γ3}"']


def test_all_faults_that_do_not_end_the_reading_come_at_once_in_order() -> None:
    found = faults("a: !x 1\nb: {c: 1, c: 2}\na: 2\n3: 4\n")
    assert [(code, place) for code, place, _ in found] == [
        ("unknown-tag", "1:4"),
        ("duplicate-key", "2:11"),
        ("duplicate-key", "3:1"),
        ("key-not-text", "4:1"),
    ]


def test_merge_keys_fill_in_what_a_mapping_does_not_say() -> None:
    text = "a: &a {x: 1, y: 2}\nb: &b {y: 3, z: 4}\nc:\n  <<: [*a, *b]\n  x: 5\n"
    document = parse_document(text, "test.yaml")
    assert document.data["c"] == {"x": 5, "y": 2, "z": 4}
    assert document.span(("c", "x")) == Span(5, 6, 5, 7)
    assert document.span(("c", "z")) == Span(2, 17, 2, 18)


def test_each_use_of_an_alias_is_a_value_of_its_own() -> None:
    document = parse_document("a: &x {b: 1}\nc: *x\n", "test.yaml")
    assert document.with_value(("c", "b"), 2, "in a test").data == {"a": {"b": 1}, "c": {"b": 2}}
    assert document.data == {"a": {"b": 1}, "c": {"b": 1}}


@pytest.fixture(scope="module")
def small() -> Document:
    return parse_document("a: 1\nbc:\n  - run: x  # why\n    on: {k: [1,\n      2]}\n\n# end\nlast:\n", "test.yaml")


@pytest.mark.parametrize(
    ("path", "value", "key"),
    [
        (("a",), (1, 4, 1, 5), (1, 1, 1, 2)),
        (("bc",), (3, 3, 5, 10), (2, 1, 2, 3)),
        (("bc", 0), (3, 5, 5, 10), (3, 5, 3, 18)),
        (("bc", 0, "run"), (3, 10, 3, 11), (3, 5, 3, 8)),
        (("bc", 0, "on", "k", 1), (5, 7, 5, 8), (5, 7, 5, 8)),
        (("bc", 0, "missing"), (3, 5, 5, 10), (3, 5, 3, 18)),
        (("bc", 0, "on", "k", 7, "x"), (4, 13, 5, 9), (4, 10, 4, 11)),
        (("nothing", "here"), (1, 1, 8, 6), (1, 1, 1, 5)),
        (("last",), (8, 6, 8, 7), (8, 1, 8, 5)),
    ],
)
def test_spans(small: Document, path: tuple[str | int, ...], value: tuple[int, ...], key: tuple[int, ...]) -> None:
    assert small.span(path) == Span(*value)
    assert small.key_span(path) == Span(*key)


@pytest.mark.parametrize("end", ["\n", "\r\n", "\r"])
@pytest.mark.parametrize("mark", ["", "\ufeff"])
def test_line_ends_and_a_byte_order_mark_move_nothing(end: str, mark: str) -> None:
    text = mark + end.join(["a: 1", "b: |", "  one", "  two", "c: 3", ""])
    document = parse_document(text, "test.yaml")
    assert document.data == {"a": 1, "b": "one\ntwo\n", "c": 3}
    assert document.key_span(("a",)) == Span(1, 1, 1, 2)
    assert document.key_span(("c",)) == Span(5, 1, 5, 2)
    assert document.source_text(("b",)).places[4] == (4, 3)


def test_only_a_scalar_has_a_source_text(small: Document) -> None:
    assert small.source_text(("a",)).text == "1"
    assert small.key_source_text(("bc", 0, "run")).places == ((3, 5), (3, 6), (3, 7), (3, 8))
    for path in [("bc",), ("missing",)]:
        with pytest.raises(KeyError):
            small.source_text(path)
    with pytest.raises(KeyError):
        small.key_source_text(("bc", 0))
