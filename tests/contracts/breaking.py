"""Which rules of a contract an entry breaks."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TypeVar

from graspdsl.contracts.rule import Rule

Thing = TypeVar("Thing")


def broken(rules: Mapping[str, Rule[Thing]], entry: Thing) -> set[str]:
    """The codes of what is said of an entry."""
    found = [diagnostic for rule in rules.values() for diagnostic in rule(entry)]
    assert all(diagnostic.message and "\n" not in diagnostic.message and diagnostic.hint for diagnostic in found)
    return {diagnostic.code for diagnostic in found}
