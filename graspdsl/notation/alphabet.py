"""The characters a formula is made of, and what to say about any other."""

from __future__ import annotations

import re
import unicodedata

from graspdsl.notation.characters import LOOKALIKES, shown
from graspdsl.notation.fault import Fault
from graspdsl.notation.names import canonical
from graspdsl.notation.slips import resource_slip

_FOREIGN = re.compile(r"[^A-Za-zΑ-Ωα-ω0-9_\s|(){}<>,.+\-◁]+")
_LATEX = re.compile(r"[\\^$]|_\s*\{")
_SUBSCRIPT = re.compile(r"([A-Za-zΑ-Ωα-ω]+)_\s*\{\s*([A-Za-zΑ-Ωα-ω0-9]+(?:\s*,\s*[0-9]+)*)\s*\}")
_QUOTES = "“”„«»‘’‚`´\"'"


def latex(folded: str, written: str) -> Fault | None:
    """A fault at the first sign of LaTeX; complaining about each of its signs would help nobody.

    ``folded`` is the text with its characters folded, ``written`` the same text as the user wrote it.
    """
    sign = _LATEX.search(folded)
    if not sign:
        return None
    subscript = _SUBSCRIPT.search(folded)
    if subscript and not _LATEX.search(_SUBSCRIPT.sub("", folded)):
        start, end = subscript.span()
        message = f"a subscript stands without braces, but {shown(written[start:end])} has some"
        return Fault(start, end, "unexpected-character", message, _plain(*subscript.groups()))
    return Fault(
        sign.start(),
        sign.end(),
        "unexpected-character",
        f"unexpected {shown(written[sign.start() : sign.end()])}: this looks like LaTeX",
        "write it plainly, effector transform first: φ_fr|τ_fr(Γ_τ) σ_fr(Γ_σ); ◁ or <| for \\triangleleft",
    )


def _plain(head: str, subscript: str) -> str:
    name = canonical(f"{head}_{subscript}")
    return resource_slip(name) or f"write {name}"


def foreign_characters(folded: str, written: str) -> list[Fault]:
    """A fault for every run of characters that no formula contains; the arguments are those of :func:`latex`."""
    return [_fault(written[run.start() : run.end()], run.start()) for run in _FOREIGN.finditer(folded)]


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
        return "a formula holds no definition; the left side stands before the colon"
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
