"""Characters that look like YAML and are none: named where they stand, and the rest of the file is read as well."""

from __future__ import annotations

import time

import pytest
from spec.conftest import GOOD
from spec.test_faults import complaints

from graspdsl.diagnostics import DiagnosticError, Span
from graspdsl.places.document import parse_document, parse_with_faults

BLANKS = {
    "\xa0": "U+00A0 (no-break space)",
    "\u2003": "U+2003 (em space)",
    "\u2007": "U+2007 (figure space)",
    "\u2009": "U+2009 (thin space)",
    "\u202f": "U+202F (narrow no-break space)",
    "\u3000": "U+3000 (ideographic space)",
    "\u200d": "U+200D (zero width joiner)",
}
# What is written, with _ for a blank of another kind, in place of what; and where those blanks are.
SEPARATING = [
    ("  world: bullet  ", "  world:_bullet  ", [(5, 9)]),
    ("  world: bullet  ", "  world_: bullet  ", [(5, 8)]),
    ("  world: bullet  ", "__world: bullet  ", [(5, 1)]),
    ("  world: bullet  ", "  world: _bullet_# ", [(5, 10), (5, 17)]),
    ("  hand: barrett\n", "__hand:_barrett_\n", [(6, 1), (6, 8), (6, 16)]),
    ("friction: 0.4\n", "friction: 0.4_\n", [(9, 16)]),
    ("friction: 0.4\n", "friction: 0.4_# none\n", [(9, 16)]),
    ("resources:\n", "resources:_\n", [(11, 11)]),
    ('  Γ: "{γ1, <γ2,γ3>}"', '  "Γ":_"{γ1, <γ2,γ3>}"', [(15, 7)]),
    ("  - run: π_close|Γ Γ\n", "  -_run: π_close|Γ Γ\n", [(21, 4)]),
    ("{contact: all, hold: 0.2}", "{contact:_all_,_hold_: 0.2_}", [(22, 21), (22, 25), (22, 27), (22, 32), (22, 38)]),
    ("resources:\n", "\n_\nresources:\n", [(12, 1)]),
]


@pytest.mark.parametrize("blank", BLANKS)
@pytest.mark.parametrize(("old", "new", "places"), SEPARATING)
def test_blanks_of_other_kinds_are_named_and_separate(
    old: str, new: str, places: list[tuple[int, int]], blank: str
) -> None:
    assert GOOD.count(old) == 1
    found = complaints(GOOD.replace(old, new.replace("_", blank)) if "_run" not in new else _items(old, new, blank))
    assert [(d.code, d.span and (d.span.line, d.span.column)) for d in found] == [("odd-blank", at) for at in places]
    assert {d.message for d in found} == {f"{BLANKS[blank]} stands where YAML needs a plain space"}
    assert {d.hint for d in found} == {"write a plain space instead"}


def _items(old: str, new: str, blank: str) -> str:
    return GOOD.replace(old, new.replace("-_", f"-{blank}"))


@pytest.mark.parametrize("blank", BLANKS)
@pytest.mark.parametrize(
    "text",
    ["a: b_c", "a: '_b'", 'a: "b_"', "a: |\n  _b_\n", "a: b # c_", "a: π|Γ_Γ", "a: note:_b", "'_a': b", "a: [b_c, d]"],
)
def test_blanks_of_other_kinds_are_text_within_a_text(text: str, blank: str) -> None:
    text = text.replace("_", blank)
    document, faults = parse_with_faults(text, "test.yaml")
    assert (document.text, faults) == (text, [])


def test_the_faults_of_a_file_with_other_blanks_are_told_too() -> None:
    text = GOOD.replace("  sensing: load-cell", "\xa0\xa0sensing:\xa0lod-cell").replace("count: 58", "count:\xa00")
    assert [(d.code, d.span) for d in complaints(text)] == [
        ("odd-blank", Span(10, 1, 10, 3)),
        ("odd-blank", Span(10, 11, 10, 12)),
        ("unknown-value", Span(10, 12, 10, 20)),
        ("odd-blank", Span(29, 9, 29, 10)),
        ("out-of-range", Span(29, 10, 29, 11)),
    ]


@pytest.mark.parametrize("character", "\u200b\ufeff\xad\u2060\u202e\u2066\u2028\u2029\x85\x0c\x0b\x1b\x7f")
@pytest.mark.parametrize("before", ["world:", "  γ1: finger-3 # the", "world: bul", "  Γ: "])
def test_what_is_nowhere_seen_is_named_wherever_it_stands(before: str, character: str) -> None:
    text = f"{before}{character}x\nb: {character}"
    found = complaints(text)
    assert [d.code for d in found] == ["bad-character"] * 2
    assert [d.span for d in found] == [Span(1, len(before) + 1, 1, len(before) + 2), Span(2, 4, 2, 5)]
    assert all(f"U+{ord(character):04X}" in d.message for d in found)


@pytest.mark.parametrize(
    ("written", "message", "plainly"),
    [
        (r"\tau_gx|Γ Γ", r"'\t' is a tab in double quotes, so that this is no \tau", "tau_gx|Γ Γ"),
        (
            r"\phi_f|\tau_f(Γ)",
            r"'\p' means nothing in double quotes, so that this is no \phi",
            "phi_f|tau_f(Γ)",
        ),
        (r"\nu", r"'\n' is a line break in double quotes, so that this is no \nu", "nu"),
        (r"\rho", r"'\r' is a carriage return in double quotes, so that this is no \rho", "rho"),
        (r"\beta", r"'\b' is a backspace in double quotes, so that this is no \beta", "beta"),
        (r"\alpha", r"'\a' is a bell in double quotes, so that this is no \alpha", "alpha"),
        (r"\epsilon", r"'\e' is an escape character in double quotes, so that this is no \epsilon", "epsilon"),
        (r"\varphi_f", r"'\v' is a vertical tab in double quotes, so that this is no \varphi", "phi_f"),
        (r"\Pi", r"'\P' is a line end in double quotes, so that this is no \Pi", "Pi"),
        (r"\Lambda", r"'\L' is a line end in double quotes, so that this is no \Lambda", "Lambda"),
        (r"\xi", r"'\x' means nothing in double quotes, so that this is no \xi", "xi"),
        (r"π_a \triangleleft π_b", r"'\t' is a tab in double quotes, so that this is no \triangleleft", "π_a <| π_b"),
        (r"\upsilon", r"'\u' means nothing in double quotes, so that this is no \upsilon", "upsilon"),
    ],
)
def test_latex_in_double_quotes(written: str, message: str, plainly: str) -> None:
    _, ((_, fault),) = parse_with_faults(f'a:\n  - "{written}"', "test.yaml")
    column = 6 + written.index("\\")
    assert (fault.code, fault.message, fault.span and (fault.span.line, fault.span.column)) == (
        "bad-escape",
        message,
        (2, column),
    )
    hint = f'write letters as they are or by their names, without backslashes: "{plainly}"'
    assert fault.hint == hint


def test_latex_in_double_quotes_is_read_in_plain_writing() -> None:
    text = GOOD.replace("κ_f: 0.5", r'"\kappa_f": 0.5').replace("run: π_close|Γ Γ", r'run: "\pi_close|\Gamma Γ"')
    text = text.replace("- run: π_s|Γ", r"- run: π_s|γ9")
    assert [(d.code, d.span and d.span.line) for d in complaints(text)] == [("bad-escape", 16), ("bad-escape", 21)]


@pytest.mark.parametrize(
    "text", [r'a: "one\ntwo"', r'a: "\\tau"', r"a: '\tau'", r"a: \tau", r'a: "\taut \newer"', r'a: "\x41\u0042 \" c"']
)
def test_escapes_that_are_no_latex_are_read_as_ever(text: str) -> None:
    assert parse_with_faults(text, "test.yaml")[1] == []


@pytest.mark.slow
@pytest.mark.parametrize(
    "text",
    [
        "a: " + "\xa0" * 500_000 + "x",
        "a: [" + "x\xa0," * 200_000 + "]",
        "a: [" + "x, " * 4_000 + "\xa0]" + " " * 900_000,
        "\xa0\n" * 300_000,
        'a: "' + "\\tau" * 200_000 + '"',
        "a: [" + '"\\tau", ' * 5_000 + "]",
        "a:\xa0b\n" * 100_000,
        ("a: " + "\xa0 " * 300_000 + "#"),
    ],
)
def test_very_many_of_them_take_no_time(text: str) -> None:
    began = time.monotonic()
    with pytest.raises(DiagnosticError) as caught:
        parse_document(text, "test.yaml")
    assert len(caught.value.diagnostics) <= 21
    assert time.monotonic() - began < 20.0
