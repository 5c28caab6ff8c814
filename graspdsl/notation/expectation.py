"""The message of a syntax error: what was expected where, and what was found, in the words of the field."""

from __future__ import annotations

from graspdsl.diagnostics import listed
from graspdsl.notation.characters import shown
from graspdsl.notation.fault import Fault
from graspdsl.notation.situation import Situation
from graspdsl.notation.slips import hint
from graspdsl.notation.syntax import ROLES

# In the order a message lists them.
_WORDS = {
    "POTENTIAL": "a potential (φ_…)",
    "ABBREVIATION": "an abbreviation (π_…)",
    "EFFECTOR": "an effector transform (τ_…)",
    "NUMBER": "a number",
    "SENSOR": "a sensor transform (σ_…)",
    "VBAR": "“|”",
    "COMMA": "“,”",
    "_SUBJECT_TO": "“◁”",
    "_THEN": "“then”",
    "RPAR": "“)”",
    "RBRACE": "“}”",
    "MORETHAN": "“>”",
    "$END": "the end",
}


def syntax_fault(halt: Situation) -> Fault:
    """The fault at the place where reading came to a halt."""
    return Fault(
        halt.at,
        halt.at + len(halt.found),
        _code(halt),
        f"expected {_expected(halt)}, found {_found(halt)}",
        hint(halt),
    )


def _code(halt: Situation) -> str:
    if halt.kind == "$END":
        return "unexpected-end"
    if halt.kind in ("NAME", "_THEN", *ROLES):
        return "unexpected-word"
    if halt.kind == "NUMBER":
        return "unexpected-number"
    return "unexpected-sign" if halt.kind else "unexpected-character"


def _expected(halt: Situation) -> str:
    after = _after(halt)
    if halt.could_be("POTENTIAL", "NUMBER"):
        return "a reference (numbers, a parameter, a sensor transform or a controller)"
    if halt.could_be("POTENTIAL"):
        return f"a controller (φ_… or π_…){after}"
    if halt.accepted == {"SENSOR"} and halt.role == "EFFECTOR":
        return f"{_WORDS['SENSOR']} after the effector transform"
    if halt.could_be("NAME", "LPAR"):
        side = "effector" if halt.previous == "|" else "sensor"
        return f"the {side} resources of {halt.owner}"
    if halt.accepted == {"LPAR"}:
        return f"“(” and the resources of {halt.owner}"
    if halt.could_be("NAME", "LBRACE"):
        return f"resources{after}"
    if halt.could_be("NAME", "_OPEN_VIRTUAL"):
        closing = " or “}”" if halt.could_be("RBRACE") else " or “>”" if halt.could_be("MORETHAN") else ""
        return f"a resource{closing}{after}"
    if halt.could_be("NAME"):
        return f"a name{after}"
    words = [word for terminal, word in _WORDS.items() if terminal in halt.accepted]
    if halt.could_be("LPAR"):
        words.insert(0, "a reference in brackets")
    return f"{listed(words, 'or')}{after}"


def _after(halt: Situation) -> str:
    if not halt.previous:
        return ""
    return f" after {halt.previous if _is_word(halt.previous) else shown(halt.previous)}"


def _found(halt: Situation) -> str:
    if halt.kind == "$END":
        return "the end" if halt.previous else "nothing"
    if halt.kind in ROLES:
        return f"the {ROLES[halt.kind]} {halt.found}"
    return halt.found if _is_word(halt.found) and halt.kind != "_THEN" else shown(halt.found)


def _is_word(text: str) -> bool:
    return text[-1].isalnum() or text[-1] == "."
