"""The characters a formula is made of, and what to say about any other."""

from __future__ import annotations

import re
import unicodedata

from graspdsl.notation.characters import LOOKALIKES, shown
from graspdsl.notation.fault import Fault
from graspdsl.notation.reading import Reading

_FOREIGN = re.compile(r"[^A-Za-zΑ-Ωα-ω0-9_\s|(){}<>,.+\-◁]+")
_QUOTES = "“”„«»‘’‚`´\"'"


def foreign_characters(reading: Reading) -> list[Fault]:
    """A fault for every run of characters that no formula contains."""
    return [_fault(reading.spelt[run.start() : run.end()], run.start()) for run in _FOREIGN.finditer(reading.text)]


def _fault(run: str, start: int) -> Fault:
    what = "character" if len(run) == 1 else "characters"
    return Fault(start, start + len(run), "unexpected-character", f"unexpected {what} {shown(run)}", _hint(run))


def _hint(run: str) -> str:
    greek = next((character for character in run if character in LOOKALIKES), None)
    if greek:
        return f"{shown(greek)} only looks Greek: write {LOOKALIKES[greek]}"
    if run[0] in "°º":
        return "angles are in radians, and numbers bare: 1.5708 for 90°"
    if run[0] in _QUOTES:
        return "a formula holds no quotation marks; those of YAML around it are \" and '"
    if run[0] in "[]":
        return "the brackets of a formula are ( ), { } for sets and < > for virtual contacts"
    if run[0] in ";:":
        return "separate with a comma"
    if run[0] in "=≡":
        return "a definition stands under controllers, in a spec; here its right side is enough"
    if not run.isprintable():
        return "delete it; it is invisible and was probably pasted along"
    if run[0].isdigit() or run[0].isnumeric():
        return "write the number in ordinary digits"
    letters = unicodedata.normalize("NFKC", run)
    if letters != run and letters.isascii() and letters.isalpha():
        return f"write {letters}"
    if run[0].isalpha():
        return "names are made of Latin and Greek letters without accents, digits and _"
    return "a formula is made of names, numbers and the signs | ◁ , ( ) { } < >"
