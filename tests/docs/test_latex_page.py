"""The page on LaTeX: its table is true. That its blocks do what they say is seen with all pages'."""

from __future__ import annotations

import re

import pytest

from graspdsl.notation.parser import parse_expression

from .pages import PAGES


@pytest.mark.parametrize("row", re.findall(r"^\| `(\\p(?:hi|i)_.*?)`.*? \| `(.*?)`:", PAGES["latex.md"], flags=re.M))
def test_its_table_is_true(row: tuple[str, str]) -> None:
    latex, plain = row
    assert parse_expression(latex) == parse_expression(plain.replace("\\|", "|"))
