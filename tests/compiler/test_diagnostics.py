"""What is said of faulty specs: every code, with its place, its message and its hint."""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator
from pathlib import Path

import pytest

import graspdsl.compiler
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


def _codes(path: Path) -> Iterator[str]:
    """The codes in a module, as patterns: what is passed as the first argument of a complaint."""
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        name = getattr(node.func, "attr", getattr(node.func, "id", "")) if isinstance(node, ast.Call) else ""
        if isinstance(node, ast.Call) and name in {"error", "warning", "Diagnostic"} and node.args:
            yield from _patterns(node.args[0])
        if isinstance(node, ast.Assign) and any(getattr(target, "id", "") == "code" for target in node.targets):
            yield from _patterns(node.value)


def _patterns(code: ast.expr) -> Iterator[str]:
    match code:
        case ast.Constant(str(text)):
            yield re.escape(text)
        case ast.JoinedStr(values):
            yield "".join(re.escape(str(v.value)) if isinstance(v, ast.Constant) else "[a-z]+" for v in values)
        case ast.IfExp(_, body, otherwise):
            yield from (*_patterns(body), *_patterns(otherwise))


@pytest.mark.slow
def test_every_code_of_the_compiler_has_a_case() -> None:
    met = {diagnostic.code for case in CASES for diagnostic in case.diagnostics}
    modules = Path(graspdsl.compiler.__path__[0]).glob("*.py")
    known = {pattern for module in modules for pattern in _codes(module)}
    assert len(known) > 20
    assert [pattern for pattern in sorted(known) if not any(re.fullmatch(pattern, code) for code in met)] == []


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
