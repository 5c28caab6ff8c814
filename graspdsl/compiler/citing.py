"""How the chapter is cited: by an equation's number, or by a section where there is no equation."""

from __future__ import annotations


def cited(equation: str) -> str:
    """``Eq. 4.30``, or ``Sec. 4.1.3`` as it stands."""
    return equation if equation.startswith("Sec.") else f"Eq. {equation}"
