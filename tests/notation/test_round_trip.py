"""What is printed reads back as the same tree, in every spelling."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import fields

import pytest
from hypothesis import given

from graspdsl.diagnostics import SourceText, Span
from graspdsl.notation.parser import parse_expression, parse_head, parse_resources
from graspdsl.notation.printer import Printable, to_ascii, to_latex, to_unicode
from graspdsl.notation.tree import Expression, Head, Resources

from . import strategies

pytestmark = pytest.mark.slow

SPELLINGS = pytest.mark.parametrize("spelling", [to_unicode, to_ascii, to_latex])
Spelling = Callable[[Printable], str]


@SPELLINGS
@given(tree=strategies.expressions)
def test_expressions_read_back(tree: Expression, spelling: Spelling) -> None:
    assert parse_expression(spelling(tree)) == tree


@SPELLINGS
@given(tree=strategies.heads)
def test_heads_read_back(tree: Head, spelling: Spelling) -> None:
    assert parse_head(spelling(tree)) == tree


@SPELLINGS
@given(tree=strategies.resources)
def test_resources_read_back(tree: Resources, spelling: Spelling) -> None:
    assert parse_resources(spelling(tree)) == tree


@given(tree=strategies.expressions)
def test_ascii_is_ascii(tree: Expression) -> None:
    assert to_ascii(tree).isascii()


@given(tree=strategies.expressions)
def test_latex_is_ascii(tree: Expression) -> None:
    assert to_latex(tree).isascii()


@given(tree=strategies.expressions)
def test_every_node_spans_its_own_text(tree: Expression) -> None:
    text = to_unicode(tree)
    for node, span in _nodes(parse_expression(text)):
        assert text[span.column - 1 : span.end_column - 1] == to_unicode(node)


def test_places_are_those_of_the_source() -> None:
    text = "π_s|Γ Γ\n  ◁ ((π_g|γ₁ Γ))"
    expression = parse_expression(SourceText.of(text, line=7, column=5))
    spans = {to_unicode(node): span for node, span in _nodes(expression)}
    assert spans["π_s|Γ Γ ◁ π_g|γ1 Γ"] == Span(7, 5, 8, 17)
    assert spans["π_g|γ1 Γ"] == Span(8, 7, 8, 15)
    assert spans["γ1"] == Span(8, 11, 8, 13)


def test_brackets_around_a_term_belong_to_the_composition() -> None:
    text = "(π_a ◁ π_b) ◁ (π_c)"
    spans = {
        to_unicode(node): text[span.column - 1 : span.end_column - 1] for node, span in _nodes(parse_expression(text))
    }
    assert spans["(π_a ◁ π_b) ◁ π_c"] == text
    assert spans["π_a ◁ π_b"] == "π_a ◁ π_b"
    assert spans["π_c"] == "π_c"


def _nodes(node: Printable) -> Iterator[tuple[Printable, Span]]:
    """Every node of a tree, with its place."""
    yield node, node.span
    for field in fields(node):
        value = getattr(node, field.name)
        for part in value if isinstance(value, tuple) else (value,):
            if isinstance(part, Printable):
                yield from _nodes(part)
