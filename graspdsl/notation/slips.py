"""Hints: the slips people make in a formula, each recognised from the place where reading came to a halt.

``SLIPS`` is tried from the top; the first that recognises the situation speaks.
"""

from __future__ import annotations

import re
from collections.abc import Callable

from graspdsl.notation.names import canonical
from graspdsl.notation.situation import Situation
from graspdsl.notation.syntax import ROLES
from graspdsl.units import number_meant

_HEADS = {"POTENTIAL": "φ", "EFFECTOR": "τ", "SENSOR": "σ", "ABBREVIATION": "π"}
_SPELT_HEADS = {"φ": "φ", "phi": "φ", "τ": "τ", "tau": "τ", "σ": "σ", "sigma": "σ", "π": "π", "pi": "π"}
_GRAVITY = {"γ", "γg", "γ_g", "grav", "gravity", "gravitation"}
_CONTACTS = re.compile(r"[γΓ]_?([1-9](?:[,_γ]*[1-9])+)")
# "pi" begins many a word (pinch); the other heads hardly any.
_SPELT = re.compile(r"([φτσπ]|phi|tau|sigma|pi(?![a-z]))_*(.*)")


def hint(halt: Situation) -> str:
    """What would be right."""
    return next(filter(None, (slip(halt) for slip in SLIPS)))


def resource_slip(name: str) -> str | None:
    """What would be right for the canonical name of a resource that is none: γ_g for gravity, <γ2, γ3> for γ23."""
    if name != "Γ" and name.casefold() in _GRAVITY:
        return "gravity is written γ_g"
    contacts = _CONTACTS.fullmatch(name)
    members = [f"γ{digit}" for digit in re.findall("[1-9]", contacts.group(1))] if contacts else []
    if len(members) < 2 or len(set(members)) < len(members):
        return None
    virtual, short = f"<{', '.join(members)}>", "γ" + "".join(member[1:] for member in members)
    return f'contacts that act as one are written {virtual}; to name them, declare {short}: "{virtual}" in resources'


def _then_in_capitals(halt: Situation) -> str | None:
    if halt.kind == "NAME" and halt.found.lower() == "then" and halt.could_be("_THEN"):
        return "write “then” in small letters"
    return None


def _misspelt_role(halt: Situation) -> str | None:
    wanted = {_HEADS[role] for role in halt.accepted & _HEADS.keys()}
    spelt = _SPELT.match(halt.found.lower())
    if halt.kind != "NAME" or not spelt or not wanted:
        return None
    head, rest = spelt.groups()
    if _SPELT_HEADS[head] not in wanted:
        return None
    return f"did you mean {canonical(_SPELT_HEADS[head] + '_' + rest if rest else head)}?"


def _unknown_role(halt: Situation) -> str | None:
    begins_a_controller = halt.kind == "NAME" and halt.could_be("POTENTIAL") and not halt.could_be("NUMBER")
    # A reference may be a plain name; that it was meant as a controller shows at the bar.
    went_on_as_controller = halt.kind == "VBAR" and halt.could_be("SENSOR", "RPAR")
    if begins_a_controller or went_on_as_controller:
        return "a controller begins with a potential φ_… (phi_…) or is an abbreviation π_… (pi_…)"
    return None


def _sensor_first(halt: Situation) -> str | None:
    if halt.kind == "SENSOR" and halt.could_be("EFFECTOR"):
        return f"the effector transform comes first: {halt.owner}|τ_…(…) {halt.found}(…)"
    return None


def _missing_bar(halt: Situation) -> str | None:
    if not halt.could_be("VBAR"):
        return None
    if halt.role == "POTENTIAL":
        return f"write {halt.owner}|τ_…(…) σ_…(…)"
    if halt.kind in ("NAME", "LBRACE", "_OPEN_VIRTUAL", "LPAR"):
        return f"resources follow a bar, effector resources first: {halt.owner}|Γ Γ"
    return None


def _missing_resources(halt: Situation) -> str | None:
    if halt.role == "ABBREVIATION" and halt.could_be("NAME", "LPAR") and not halt.could_be("NUMBER"):
        return f"an abbreviation takes effector and then sensor resources: {halt.owner}|Γ Γ"
    return None


def _resources_without_brackets(halt: Situation) -> str | None:
    if halt.accepted == {"LPAR"}:
        return f"resources stand in brackets: {halt.owner}(Γ)"
    return None


def _hyphen_in_name(halt: Situation) -> str | None:
    after_word = halt.previous[-1:].isalnum() and not halt.previous[0].isdigit()
    if after_word and halt.found.startswith(("-", "−")) and not halt.could_be("NUMBER"):
        return "a name in a formula has no hyphen: use _"
    return None


def _unit_behind_number(halt: Situation) -> str | None:
    meant = number_meant(f"{halt.previous} {halt.found}") if halt.kind == "NAME" and halt.previous else None
    return f"numbers are bare, in SI units: {meant[0]:.6g}" if meant else None


def _missing_comma(halt: Situation) -> str | None:
    if halt.could_be("COMMA") and halt.kind in ("NAME", "NUMBER", "_OPEN_VIRTUAL", "LBRACE"):
        return f"separate with commas: {halt.previous}, {halt.found}"
    return None


def _lone_argument(halt: Situation) -> str | None:
    if halt.accepted == {"COMMA"} and halt.kind == "RPAR":
        return "brackets hold two or more arguments; a single one stands without them"
    return None


def _resources_without_set(halt: Situation) -> str | None:
    if halt.kind == "COMMA" and halt.role in ("EFFECTOR", "SENSOR") and halt.could_be("RPAR"):
        return "write several resources as a set: {γ1, γ2}"
    return None


def _set_in_set(halt: Situation) -> str | None:
    if halt.kind == "LBRACE" and halt.could_be("NAME", "_OPEN_VIRTUAL"):
        return "a set holds no sets; contacts that act as one are written <γ2, γ3>"
    return None


def _lone_operator(halt: Situation) -> str | None:
    if not halt.could_be("POTENTIAL") or halt.could_be("NUMBER"):
        return None
    operators = ("◁", "<|", "then")
    if halt.kind in ("_SUBJECT_TO", "_THEN"):
        return f"“{'then' if halt.kind == '_THEN' else '◁'}” stands between two controllers"
    if halt.previous in operators:
        return "write the controller that comes after it, or remove the operator"
    return None


def _missing_operator(halt: Situation) -> str | None:
    if halt.could_be("_SUBJECT_TO") and halt.kind in ("POTENTIAL", "ABBREVIATION"):
        return "join controllers by “◁” (subject to; the rightmost has the highest priority) or “then”"
    return None


def _bare_reference(halt: Situation) -> str | None:
    if halt.could_be("_SUBJECT_TO", "LPAR") and halt.kind in ("NAME", "NUMBER", "SENSOR"):
        return f"a reference stands in brackets: ({halt.found})"
    return None


def _second_reference(halt: Situation) -> str | None:
    if halt.could_be("_SUBJECT_TO") and not halt.could_be("LPAR") and halt.kind == "LPAR":
        return "a controller takes one reference"
    return None


def _word_in_vector(halt: Situation) -> str | None:
    if halt.accepted == {"NUMBER"}:
        return "a vector holds numbers only; a parameter stands for a whole vector: (x_ref)"
    return None


def _transform_unfinished(halt: Situation) -> str | None:
    if halt.accepted <= {"EFFECTOR", "SENSOR"}:
        return "a controller is a potential with an effector and a sensor transform: φ_…|τ_…(Γ) σ_…(Γ)"
    return None


def _stray_sign(halt: Situation) -> str | None:
    if halt.kind:
        return None
    if halt.previous.startswith(("γ", ">")) and halt.could_be("COMMA"):
        return "separate contacts with commas; those that act as one are written <γ2, γ3>"
    if halt.found == "_":
        return "a name begins with a letter, and “_” stands between its parts: φ_fr"
    return "a sign or a point belongs to a number, without space between: -0.5"


def _general(halt: Situation) -> str:
    if halt.start == "head":
        return "the left side of a definition looks like π_s|Γ_m Γ_m (x_ref), or a bare π_mine"
    if halt.could_be("POTENTIAL", "NUMBER"):
        return "for example (0.1, 0, 0.3), (x_ref), (κ_f σ_n(Γ)) or (π_gx|Γ Γ)"
    if halt.could_be("NAME") or halt.start == "resources":
        return "resources are a name (Γ, γ1), a set {γ1, γ2} or a virtual contact <γ2, γ3>"
    if halt.role == "ABBREVIATION" and halt.kind not in ROLES:
        return f"an abbreviation looks like {halt.owner}|Γ Γ (x_ref)"
    return "a controller looks like φ_fr|τ_fr(Γ) σ_fr(Γ), an abbreviation like π_gx|Γ Γ"


SLIPS: tuple[Callable[[Situation], str | None], ...] = (
    _stray_sign,
    _then_in_capitals,
    _misspelt_role,
    _unknown_role,
    _sensor_first,
    _missing_bar,
    _hyphen_in_name,
    _lone_argument,
    _unit_behind_number,
    _missing_comma,
    _resources_without_set,
    _set_in_set,
    _resources_without_brackets,
    _missing_resources,
    _lone_operator,
    _missing_operator,
    _bare_reference,
    _second_reference,
    _word_in_vector,
    _transform_unfinished,
    _general,
)
