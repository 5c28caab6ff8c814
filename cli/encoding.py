"""Text for streams that cannot write every character: Greek letters by their names, signs by their nearest."""

from __future__ import annotations

import codecs
import unicodedata

SPELL_OUT = "graspdsl-spell-out"  # the name of the error handler that does it

_SIGNS = {
    "◁": "<|", "‖": "||", "…": "...", "→": "->", "–": "-", "·": "*", "×": "x", "≡": "=", "∇": "grad ", "∈": "in",
    "“": '"', "”": '"', "█": "#", "░": ".", "─": "-", "ᵀ": "^T", "⁺": "^+", "²": "^2", "³": "^3", "⁶": "^6", "₁": "_1",
}  # fmt: skip


def install() -> None:
    """Make the error handler known to Python's encoders."""
    codecs.register_error(SPELL_OUT, _spelled_out)


def _spelled_out(error: UnicodeError) -> tuple[str, int]:
    if not isinstance(error, UnicodeEncodeError):
        raise error
    return "".join(map(_ascii, error.object[error.start : error.end])), error.end


def _ascii(character: str) -> str:
    if character in _SIGNS:
        return _SIGNS[character]
    *kind, letter = unicodedata.name(character, "?").split()
    if kind[:1] == ["GREEK"] and len(kind) == 3:
        return letter.title() if kind[1] == "CAPITAL" else letter.lower()
    return "?"
