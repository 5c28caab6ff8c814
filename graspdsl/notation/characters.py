"""Folding of characters: many code points, one meaning, and every character keeps its column.

A formula pasted from a paper, a word processor or a Japanese keyboard holds ϕ for φ, ⊲ for ◁, ｜ for |. Each is
replaced by exactly one character, so a place in the folded text is the same place in the text as written.
"""

from __future__ import annotations

import unicodedata

# What Unicode's own compatibility mapping leaves alone.
ALIASES = {
    **dict.fromkeys("⊲◃◅⨞", "◁"),
    **dict.fromkeys("⟨〈‹❬❮⧼", "<"),
    **dict.fromkeys("⟩〉›❭❯⧽", ">"),
    **dict.fromkeys("∣│❘⎮", "|"),
    **dict.fromkeys("−‐–", "-"),
    "ς": "σ",
}

# The compatibility mappings that change only the look; superscripts, circles and fractions change the meaning.
_LOOK_ONLY = {"<font>", "<wide>", "<narrow>", "<small>", "<vertical>", "<compat>", "<noBreak>"}

# Letters that only look Greek. They are never folded, since a name must not depend on what a reader sees.
LOOKALIKES = {
    "ɸ": "φ",
    "Ф": "φ",
    "ф": "φ",
    "ᴦ": "Γ",
    "Г": "Γ",
    "ɣ": "γ",
    "п": "π",
    "ᴨ": "π",
    "∏": "π",
    "т": "τ",
    "∑": "σ",
    "ơ": "σ",
    "к": "κ",
    "ĸ": "κ",
    "ɵ": "θ",
    "ѳ": "θ",
}


def _fold(character: str) -> str:
    if character.isascii() or character in ALIASES:
        return ALIASES.get(character, character)
    decomposition = unicodedata.decomposition(character)
    kind = decomposition.split(" ")[0] if decomposition.startswith("<") else ""
    folded = unicodedata.normalize("NFKC", character)
    folded = ALIASES.get(folded, folded)
    subscript_digit = kind == "<sub>" and folded.isdecimal()
    if len(folded) != 1 or not (kind == "" or kind in _LOOK_ONLY or subscript_digit):
        return character
    return folded


def fold(text: str) -> str:
    """The text with every character in its canonical form; as long as the text, and folding again changes nothing."""
    return text if text.isascii() else "".join(map(_fold, text))


def shown(text: str, limit: int = 24) -> str:
    """The text in quotation marks for a message: cut when long, and invisible or combining characters by code point."""
    text = text if len(text) <= limit else text[: limit - 1] + "…"
    if all(character.isprintable() and unicodedata.category(character)[0] not in "MZ" for character in text):
        return f"“{text}”"
    return " ".join(f"U+{ord(character):04X}" for character in text)
