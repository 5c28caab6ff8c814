"""The definitions in a LaTeX document: its equations, told from the text around them and from other mathematics."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise

from graspdsl.diagnostics import SourceText
from graspdsl.notation.latex import plain

_OPENING = re.compile(
    r"\\\\|\\[%$]|%[^\n]*|\$\$?|\\\[|\\\("
    r"|\\begin\{(verbatim|lstlisting|comment)\*?\}.*?\\end\{\1\*?\}|\\iffalse\b.*?\\fi\b"
    r"|\\begin\{((?:equation|align|gather|multline|eqnarray|flalign|displaymath|math|dmath)\*?)\}"
    r"|\\begin\{((?:alignat|IEEEeqnarray)\*?)\}(?:\[[^\]\n]*\])?\{[^{}\n]*\}",
    re.DOTALL,
)
_CLOSING = {"$": "$", "$$": "$$", "\\[": "\\]", "\\(": "\\)"}
_ROW = re.compile(r"\\\\(?:\[[^\]\n]*\])?|\\begin\b|\\end\b|\\.|[{}]", re.DOTALL)
_DEFINES = re.compile(r":=|\\(?:equiv|triangleq|coloneqq|coloneq|doteq|defeq|eqdef)(?![A-Za-z])|[=≡≜]")
_TAG = re.compile(r"\\tag\*?\{\(?([^{}]*?)\)?\}")
_NUMBER = re.compile(r"\(([A-Z]?[\d.]*\d[a-z]?)\)\Z")
_BEHIND_NUMBER = re.compile(r"(?:\\label\{[^{}]*\}|\\end\{[a-z]+\*?\})\Z")
_STOPS = " \t\r\n$.,;"
_CONTROLLER = re.compile(r"π(?:_|\d|\s*\|)")
_OF_CONTROLLERS = re.compile(r"\\(?:var)?phi(?![A-Za-z])|\\pi(?![A-Za-z])|[φπ]")
_NAME = re.compile(r"[^\W\d]\w*")


@dataclass(frozen=True, slots=True)
class Equation:
    """A definition in a document: of a controller, or of resources; ``number`` is the equation's, where it has one."""

    source: SourceText
    number: str
    of_controller: bool


def definitions_in(text: str) -> tuple[list[Equation], int]:
    """What a document defines, in its order, and how many of its other formulas were passed over.

    A definition is an equation with π_… on its left and controllers on its right, or one of a set or virtual contact
    with γ or Γ on its left, or with nothing else on its right; whether it can be read is not asked yet.
    """
    whole = SourceText.of(text)
    found: list[Equation] = []
    others = 0
    for start, end in _formulas(text):
        for first, last in _rows(text, start, end):
            kind = _kind(text[first:last])
            if kind is None:
                others += 1
                continue
            source = SourceText(text[first:last], whole.places[first : last + 1])
            found.append(Equation(source, _number(text[first:last]), kind))
    return found, others


def _formulas(text: str) -> Iterator[tuple[int, int]]:
    """Where mathematics stands in a document."""
    missing: set[str] = set()  # closing signs that are not there any more
    at = 0
    while opening := _OPENING.search(text, at):
        at = opening.end()
        environment = opening.group(2) or opening.group(3)
        closing = f"\\end{{{environment}}}" if environment else _CLOSING.get(opening.group())
        if closing is None or closing in missing:
            continue
        end = text.find(closing, at)
        if end < 0:
            missing.add(closing)
            continue
        yield at, end
        at = end + len(closing)


def _rows(text: str, start: int, end: int) -> Iterator[tuple[int, int]]:
    """The equations of some mathematics: its rows, each with those after it that define nothing."""
    cuts, depth = [], 0
    for sign in _ROW.finditer(text, start, end):
        depth += {"{": 1, "}": -1, "\\begin": 1, "\\end": -1}.get(sign.group(), 0)
        if sign.group().startswith("\\\\") and depth == 0:
            cuts.append(sign.span())
    first = start
    for (cut, after), (following, _) in pairwise([*cuts, (end, end)]):
        left = _DEFINES.split(text[after:following], maxsplit=1)
        if len(left) > 1 and plain(left[0]).strip():
            yield first, cut
            first = after
    yield first, end


def _kind(row: str) -> bool | None:
    """Whether a row defines a controller (True), resources (False) or nothing (None)."""
    sides = _DEFINES.split(row, maxsplit=1)
    if len(sides) < 2:
        return None
    left, right = plain(sides[0]).strip(), plain(sides[1]).lstrip()
    if _CONTROLLER.match(left) and _OF_CONTROLLERS.search(sides[1]):
        return True
    if not _NAME.fullmatch(left) or right[:1] not in ("{", "<"):
        return None
    # Other sets and inner products are written alike: these are of contacts.
    members = _NAME.findall(right)
    return False if left[0] in "γΓ" or (members and all(name[0] in "γΓ" for name in members)) else None


def _number(row: str) -> str:
    tag, row = _TAG.search(row), row.rstrip(_STOPS)
    while behind := _BEHIND_NUMBER.search(row):
        row = row[: behind.start()].rstrip(_STOPS)
    number = tag or _NUMBER.search(row)
    return " ".join(number.group(1).split()) if number else ""
