"""What people write between two controllers instead of ◁ and ``then``."""

from __future__ import annotations

import re
from collections.abc import Iterable

from graspdsl.notation.characters import shown
from graspdsl.notation.fault import Fault
from graspdsl.notation.reading import Reading

_SUBJECT_TO = "write “◁” or “<|” (subject to): the controller on its right has the higher priority"
_THEN = "write “then”: one controller to convergence, then the next"
_EITHER = "join controllers by “◁” (subject to; the rightmost has the highest priority) or “then”"

_MEANT = {_SUBJECT_TO: ("◁",), _THEN: ("then",), _EITHER: ("◁", "then")}  # by the hint

_WORDS = {
    **dict.fromkeys(("and then", "followed by", "before"), _THEN),
    **dict.fromkeys(("subject to", "subject-to", "s.t.", "after"), _SUBJECT_TO),
    **dict.fromkeys(("and", "or", "with"), _EITHER),
}
# By the first sign of what stands there; a definition's signs (= ≡ :) have another complaint.
_SIGNS = {
    **dict.fromkeys("⊳▷▹▻►▶◀◂◄◅⊴⊵⧏⧐⋉⋊∘○◦⚬≺≻≼≽<>←⟵⇐«≪≫⊂⊃⊏⊐", _SUBJECT_TO),
    **dict.fromkeys(";,→⟶⇒⟹↦⨾»", _THEN),
}
_ARROW = re.compile(r"[-=~|]*>+|>>+")
_BETWEEN = re.compile(
    rf"(?<![\w.])(?:{'|'.join(map(re.escape, sorted(_WORDS, key=len, reverse=True)))})(?![\w.])|[^\w\s(){{}}]+",
    re.IGNORECASE,
)
_CONTROLLER = re.compile(r"[\s(]*(?:φ|phi|π|pi)(?![A-Za-zΑ-Ωα-ω])")
_NAME_OF_CONTROLLER = re.compile(r"(?:φ|phi|π|pi)(?![A-Za-zΑ-Ωα-ω])\w*\Z")


def operator_faults(reading: Reading, brackets: Iterable[Fault]) -> list[Fault]:
    """A fault for whatever stands as an operator before a controller and is none.

    ``brackets`` is what is wrong with the formula's brackets: a ``>`` that closes nothing is an operator too.
    """
    folded = reading.text
    unmatched = {fault.start for fault in brackets}
    faults = []
    for found in _BETWEEN.finditer(folded):
        start, end = found.span()
        while start < end and folded[start] == ">" and start not in unmatched:
            start += 1
        sign = folded[start:end]
        controller = _CONTROLLER.match(folded, end)
        if sign in ("", "◁", "<|") or sign[0] in ":≡≜" or controller is None:
            continue
        if sign[0] == "<" and start not in unmatched and (">" in sign or "(" in controller.group()):
            continue  # an empty virtual contact, and the reference behind it
        before = folded[:start].rstrip()
        if before[-1:] not in (")", "}", ">") and not before[-1:].isalnum():
            continue
        depth = {bracket: before.count(bracket) for bracket in "(){}"}
        inside = (depth["("] > depth[")"] and sign == ",") or depth["{"] > depth["}"]
        if inside or (sign == "|" and _NAME_OF_CONTROLLER.search(before)):
            continue
        hint = _hint(sign)
        if hint is not None:
            operator = reading.written(start, end)
            message = f"there is no operator {f'“{operator}”' if operator.isascii() else shown(operator)}"
            faults.append(Fault(start, end, "unknown-operator", message, hint, _MEANT[hint]))
    return faults


def _hint(sign: str) -> str | None:
    word = " ".join(sign.lower().split())
    if word in _WORDS:
        return _WORDS[word]
    if len(sign) > 1 and _ARROW.fullmatch(sign):
        return _THEN
    if sign[0] == "=":
        return None
    return _SIGNS.get(sign[0], _EITHER)
