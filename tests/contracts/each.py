"""A test for each rule of a contract."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import pytest

from graspdsl.contracts.rule import Rule


def each_rule(rules: Mapping[str, Rule[Any]], *slow: str) -> pytest.MarkDecorator:
    """The parameter ``rule``, those of these names marked as slow."""
    marked = {f"contract-{name}" for name in slow}
    assert marked <= {*rules}
    found = [pytest.param(rule, marks=pytest.mark.slow if code in marked else ()) for code, rule in rules.items()]
    return pytest.mark.parametrize("rule", found, ids=rules)
