"""Brackets: whether they match, how deep they nest, and where a formula falls apart at its outermost level."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass, field

from graspdsl.notation.fault import Fault

MAXIMUM_DEPTH = 32

_CLOSING = {"(": ")", "{": "}", "<": ">"}
_OPENING = {closing: opening for opening, closing in _CLOSING.items()}
# "<|" is the operator ◁, not a bracket.
_SIGN = re.compile(r"<\||[(){}<>]")
_SEPARATOR = re.compile(r"<\||◁|(?<![\wΑ-ω])then(?!\w)|[(){}<>]")


@dataclass
class _Open:
    """A bracket that waits for its partner, and closing brackets of other kinds met meanwhile."""

    at: int
    kind: str
    strays: list[int] = field(default_factory=list)


def bracket_faults(text: str) -> list[Fault]:
    """What is wrong with the brackets of a folded text: each unmatched one, or the one that goes too deep."""
    faults: list[Fault] = []
    waiting: list[_Open] = []
    for at, sign in _brackets(text):
        if sign in _CLOSING:
            waiting.append(_Open(at, sign))
            if len(waiting) > MAXIMUM_DEPTH:
                return [*faults, _too_deep(at)]
            continue
        partner = next(
            (place for place in reversed(range(len(waiting))) if waiting[place].kind == _OPENING[sign]), None
        )
        if partner is not None:
            faults += [_unclosed(text, bracket, before=at) for bracket in waiting[partner + 1 :]]
            faults += [_closes_nothing(text, stray) for stray in waiting[partner].strays]
            del waiting[partner:]
        elif waiting:
            waiting[-1].strays.append(at)
        else:
            faults.append(_closes_nothing(text, at))
    faults += [_unclosed(text, bracket) for bracket in waiting]
    return sorted(faults)


def outer_terms(text: str) -> list[tuple[int, int]]:
    """The stretches between the ◁ and ``then`` that stand outside all brackets; the brackets must match."""
    terms: list[tuple[int, int]] = []
    depth = start = 0
    for match in _SEPARATOR.finditer(text):
        sign = match.group()
        if sign in _CLOSING:
            depth += 1
        elif sign in _OPENING:
            depth -= 1
        elif depth == 0:
            terms.append((start, match.start()))
            start = match.end()
    return [*terms, (start, len(text))]


def _brackets(text: str) -> Iterator[tuple[int, str]]:
    for match in _SIGN.finditer(text):
        if match.group() != "<|":
            yield match.start(), match.group()


def _unclosed(text: str, bracket: _Open, before: int | None = None) -> Fault:
    closing = _CLOSING[bracket.kind]
    if bracket.strays:
        stray = bracket.strays[0]
        return Fault(
            stray,
            stray + 1,
            "mismatched-bracket",
            f"“{text[stray]}” cannot close “{bracket.kind}”",
            f"“{bracket.kind}” is closed by “{closing}”",
        )
    where = "" if before is None else f" before “{text[before]}”"
    return Fault(
        bracket.at,
        bracket.at + 1,
        "unbalanced-bracket",
        f"“{bracket.kind}” is not closed{where}",
        f"add the missing “{closing}”{where}",
    )


def _closes_nothing(text: str, at: int) -> Fault:
    sign = text[at]
    return Fault(
        at, at + 1, "unbalanced-bracket", f"“{sign}” closes nothing", f"remove it, or open “{_OPENING[sign]}” before it"
    )


def _too_deep(at: int) -> Fault:
    return Fault(
        at,
        at + 1,
        "too-deep",
        f"brackets nest deeper than {MAXIMUM_DEPTH} levels here",
        "define parts of the formula under names of their own",
    )
