"""Rules: what each asks of an entry of a table, and what is said of one that breaks it."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Container, Iterator, Mapping
from dataclasses import dataclass
from typing import Generic, TypeVar

import numpy as np

from graspdsl.diagnostics import Diagnostic, Severity

Thing = TypeVar("Thing")
Breach = tuple[str, str]  # what is wrong, and what would be right
Check = Callable[[Thing], Iterator[Breach]]


@dataclass(frozen=True, slots=True)
class Rule(Generic[Thing]):
    """One rule of a contract: a diagnostic for each breach, none for an entry that keeps it.

    An exception out of an entry's own code is a breach, too: here it is a stranger's. A breach of a rule about wording
    alone is a warning.
    """

    code: str
    check: Check[Thing]
    name: Callable[[Thing], str]
    severity: Severity = Severity.ERROR

    def __call__(self, entry: Thing) -> Iterator[Diagnostic]:
        """The breaches of an entry."""
        found: list[Breach] = []
        try:
            with np.errstate(all="ignore"):  # of numbers that are none the rules tell
                found += self.check(entry)
        except Exception as error:
            law = " ".join((self.check.__doc__ or "").split())
            found.append((f"raises {type(error).__name__}: {error}", law))
        for message, hint in found:
            yield Diagnostic(self.code, f"{self.name(entry)}: {message}", hint=hint or None, severity=self.severity)


def class_of(entry: object) -> str:
    """The name of an entry's class."""
    return entry.__name__ if inspect.isclass(entry) else type(entry).__name__


def contract(
    *checks: Check[Thing], name: Callable[[Thing], str] = class_of, wording: Container[Check[Thing]] = ()
) -> Mapping[str, Rule[Thing]]:
    """The rules of these checks by their codes, each the name of its function: ``contract-gradient``.

    ``name``: what an entry is called in what is said of it. ``wording``: those of the checks that ask for words alone.
    """
    rules = [
        Rule(
            f"contract-{check.__name__.replace('_', '-')}",
            check,
            name,
            Severity.WARNING if check in wording else Severity.ERROR,
        )
        for check in checks
    ]
    return {rule.code: rule for rule in rules}
