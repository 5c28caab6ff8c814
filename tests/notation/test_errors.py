"""Tables of text and the complaint it gets: exact place, message and hint."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from graspdsl.diagnostics import Diagnostic, DiagnosticError, SourceText, Span
from graspdsl.notation.brackets import MAXIMUM_DEPTH
from graspdsl.notation.parser import MAXIMUM_FAULTS, MAXIMUM_LENGTH, parse_expression, parse_head, parse_resources

Parse = Callable[[str], object]


def _errors() -> list[str]:
    """The blocks of errors.txt: the formula, carets under the place, code and message, hint."""
    lines = Path(__file__).with_name("errors.txt").read_text(encoding="utf-8").splitlines()
    return ["\n".join(lines[start : start + 4]) for start in range(0, len(lines), 5)]


# Every fault of a formula, as code and place (start column, end column).
SEVERAL = [
    ("x ◁ y ◁ z then π_a", [("unexpected-word", 1, 2), ("unexpected-word", 5, 6), ("unexpected-word", 9, 10)]),
    ("π_é ◁ π_a|Γ ◁ σ_x(Γ)", [("unexpected-character", 3, 4), ("unexpected-end", 12, 13), ("unexpected-word", 15, 18)]),
    ("π_s|[γ1] Γ", [("unexpected-character", 5, 6), ("unexpected-character", 8, 9)]),
    (
        "π_a|{γ1 <γ2 Γ) (",
        [("unbalanced-bracket", 5, 6), ("mismatched-bracket", 14, 15), ("unbalanced-bracket", 16, 17)],
    ),
    ("π_é|(Γ Γ", [("unexpected-character", 3, 4), ("unbalanced-bracket", 5, 6)]),
    ("π_a ◁ ◁ ◁ π_b|Γ", [("unexpected-sign", 7, 8), ("unexpected-end", 16, 17)]),
    ("π_a|Γ Γ (1e999, 1, -1e999)", [("number-too-large", 10, 15), ("number-too-large", 20, 26)]),
]

OTHER_STARTS = [
    (parse_head, "π_s|{γ1} Γ", 5, "expected the effector resources of π_s, found “{”"),
    (parse_head, "φ_fr", 1, "expected an abbreviation (π_…), found the potential φ_fr"),
    (parse_head, "π_s|Γ Γ (1)", 10, "expected a name after “(”, found 1"),
    (parse_resources, "{γ1, φ_x}", 6, "expected a resource after “,”, found the potential φ_x"),
    (parse_resources, "γ1 γ2", 4, "expected the end after γ1, found γ2"),
    (parse_resources, "", 1, "expected resources, found nothing"),
]


@pytest.mark.parametrize("block", _errors())
def test_error(block: str) -> None:
    text = block.split("\n")[0]
    with pytest.raises(DiagnosticError) as caught:
        parse_expression(text)
    (diagnostic,) = caught.value.diagnostics
    span = diagnostic.span
    assert span is not None
    carets = " " * (span.column - 1) + "^" * (span.end_column - span.column)
    assert f"{text}\n{carets}\n{diagnostic.code}: {diagnostic.message}\nhint: {diagnostic.hint}" == block


@pytest.mark.parametrize(("text", "expected"), SEVERAL)
def test_all_faults_at_once(text: str, expected: list[tuple[str, int, int]]) -> None:
    with pytest.raises(DiagnosticError) as caught:
        parse_expression(text)
    found = [(d.code, d.span.column, d.span.end_column) for d in caught.value.diagnostics if d.span]
    assert found == expected


@pytest.mark.parametrize(("parse", "text", "column", "message"), OTHER_STARTS)
def test_other_start_rules(parse: Parse, text: str, column: int, message: str) -> None:
    with pytest.raises(DiagnosticError) as caught:
        parse(text)
    (diagnostic,) = caught.value.diagnostics
    assert diagnostic.message == message
    assert diagnostic.span is not None
    assert diagnostic.span.column == column


def test_places_are_those_of_the_source() -> None:
    with pytest.raises(DiagnosticError) as caught:
        parse_expression(SourceText.of("π_a\n ◁ π_b|Γ\n", line=4, column=8))
    assert [diagnostic.span for diagnostic in caught.value.diagnostics] == [Span(5, 9, 5, 10)]


def _code_of(text: str) -> str:
    with pytest.raises(DiagnosticError) as caught:
        parse_expression(text)
    return caught.value.diagnostics[-1].code


def test_limits() -> None:
    deepest = "(" * MAXIMUM_DEPTH + "π_a" + ")" * MAXIMUM_DEPTH
    longest = "π_a" + " " * (MAXIMUM_LENGTH - 3)
    assert parse_expression(deepest) == parse_expression(longest) == parse_expression("π_a")
    assert _code_of(f"({deepest})") == "too-deep"
    assert _code_of(longest + " ") == "too-long"


@pytest.mark.parametrize("sign", ["(", ")", "<", "{", "<|", "\\", "π_a◁", "é "])
def test_ten_megabytes_are_refused_by_length(sign: str) -> None:
    assert _code_of(sign * (10_000_000 // len(sign))) == "too-long"


@pytest.mark.slow
@pytest.mark.parametrize("sign", ["(", ")", "<", "{", "<|", "\\", "π_a◁", "x◁", "é ", "π_a|Γ then ", "(x)", "<>(}"])
def test_the_longest_texts_get_few_complaints(sign: str) -> None:
    with pytest.raises(DiagnosticError) as caught:
        parse_expression(sign * (MAXIMUM_LENGTH // len(sign)))
    assert 1 <= len(caught.value.diagnostics) <= MAXIMUM_FAULTS


WORDS = (
    "φ_fr",
    "phi",
    "τ_x",
    "σ",
    "sigma_n",
    "π_a",
    "π_gx|Γ Γ",
    "Γ",
    "γ1",
    "x_ref",
    "then",
    "THEN",
    "1",
    "-0.5",
    "1e999",
)
SIGNS = tuple("◁<>{}()|,.-_⊲⟨｜é\\^ \n")
pieces = st.lists(st.sampled_from((*WORDS, *SIGNS, "<|", "__")), max_size=25)


def _complaints(parse: Parse, text: str) -> tuple[Diagnostic, ...]:
    try:
        parse(text)
    except DiagnosticError as error:
        return error.diagnostics or pytest.fail("refused without a complaint")
    return ()


@given(st.text(max_size=60) | pieces.map(" ".join) | pieces.map("".join))
@example("\ud800")
@example("\x00")
def test_any_text_is_read_or_refused_politely(text: str) -> None:
    for parse in (parse_expression, parse_head, parse_resources):
        for diagnostic in _complaints(parse, text):
            assert diagnostic.span is not None
            assert diagnostic.hint
            assert "expected  " not in diagnostic.message
            assert "Token(" not in diagnostic.message
            assert not any(character in diagnostic.message for character in "\x00\x1b\n\r")
