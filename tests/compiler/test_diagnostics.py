"""What is said of faulty specs: every code, with its place, its message and its hint."""

from __future__ import annotations

from pathlib import Path

import pytest

from graspdsl.compiler.program import examine, examine_expression, program_of
from graspdsl.diagnostics import DiagnosticError, Severity, Span, has_errors

from .faults import CASES, Case, report
from .specs import spec

GOLDEN = Path(__file__).parents[1] / "golden" / "diagnostics.txt"
EACH_CASE = pytest.mark.parametrize("case", CASES, ids=lambda case: case.about)


@pytest.mark.slow
def test_diagnostics_are_worded_as_ever() -> None:
    assert GOLDEN.read_text(encoding="utf-8").rstrip("\n").split("\n\n") == list(report())


@pytest.mark.slow
@EACH_CASE
def test_nothing_is_said_twice(case: Case) -> None:
    places = [(diagnostic.span, diagnostic.code, diagnostic.message) for diagnostic in case.diagnostics]
    assert places
    assert len(set(places)) == len(places)


@EACH_CASE
def test_places_lie_in_the_text_and_hints_end_without_a_stop(case: Case) -> None:
    lines = case.text.split("\n")
    for diagnostic in case.diagnostics:
        span = diagnostic.span or Span(1, 1, 1, 2)
        assert span.end_line == span.line
        assert 1 <= span.column < span.end_column <= len(lines[span.line - 1]) + 2
        assert not diagnostic.message.endswith(".")
        assert not (diagnostic.hint or "").endswith(".")


@pytest.mark.slow
@EACH_CASE
def test_only_errors_keep_a_spec_from_running(case: Case) -> None:
    found = examine(case.text, "spec.yaml", case.overrides)
    assert (found.program is None) == has_errors(found.diagnostics)


def test_faulty_spec_has_no_program() -> None:
    with pytest.raises(DiagnosticError) as caught:
        program_of(spec("π_clos|Γ Γ"), "spec.yaml")
    assert [diagnostic.code for diagnostic in caught.value.diagnostics] == ["unknown-controller"]


def test_warnings_leave_a_program_and_are_reported() -> None:
    found = examine(spec("π_close|Γ Γ", until="moment_residual: 0.1"), "spec.yaml")
    assert found.program is not None
    assert [diagnostic.severity for diagnostic in found.diagnostics] == [Severity.WARNING]


def test_unreadable_yaml_is_all_there_is_to_say() -> None:
    found = examine("graspdsl: 1\nscene: {world: bullet\n", "spec.yaml")
    assert found.program is None
    assert len(found.diagnostics) == 1


@pytest.mark.parametrize(
    ("formula", "code", "place"),
    [
        ("π_s|Γ Γ (π_g|Γ Γ)", "wrong-reference", Span(1, 10, 1, 17)),
        ("π_close|Γ\n◁ π_clos|Γ Γ", "unexpected-sign", Span(2, 1, 2, 2)),
        ("φ_fr|τ_frx(Γ)\n  σ_mr(Γ)", "wrong-sensor", Span(2, 3, 2, 10)),
    ],
)
def test_places_in_a_formula_on_its_own(formula: str, code: str, place: Span) -> None:
    with pytest.raises(DiagnosticError) as caught:
        examine_expression(formula)
    assert (code, place) in [(diagnostic.code, diagnostic.span) for diagnostic in caught.value.diagnostics]
