"""How sources are cited: by an equation's number, or by a section where there is no equation."""

from __future__ import annotations


def cited(equation: str) -> str:
    """``Eq. 4.30``; what is no bare number, as ``Sec. 4.1.3``, as it stands."""
    return f"Eq. {equation}" if equation[:1].isdigit() else equation
