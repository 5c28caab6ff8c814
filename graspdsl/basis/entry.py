"""What the entries of the basis have in common, and how their sources are cited."""

from __future__ import annotations

from abc import ABC
from typing import ClassVar


def cited(equation: str) -> str:
    """``Eq. 4.30``; what is no bare number, as ``Sec. 4.1.3``, as it stands."""
    return f"Eq. {equation}" if equation[:1].isdigit() else equation


class Entry(ABC):
    """An entry of a table: the symbol that formulas know it by, a line that says what it is, and where it comes from,
    by an equation's number or a section."""

    symbol: ClassVar[str]
    about: ClassVar[str]
    equation: ClassVar[str]

    @property
    def source(self) -> str:
        """Where it comes from, as it is cited."""
        return cited(self.equation)
