"""The spelling of names: one canonical (Unicode) spelling, one ASCII spelling, and the way between them.

A name is segments joined by ``_``: ``φ_fr`` is φ with the subscript fr. Within a segment, a run of Latin letters
that is exactly the name of a Greek letter stands for that letter: ``phi_fr``, ``G_sigma``. Where ASCII has to write a
Greek letter beside other letters, ``__`` marks the seam: ``alpha__x`` is αx. Two short forms of the chapter's
names come on top: ``g`` and ``G`` at the head are γ and Γ, and a subscript may end in theta without a
seam: ``pi_rgtheta`` is π_rgθ.
"""

from __future__ import annotations

import re
from collections.abc import Sequence

from graspdsl.notation.characters import fold
from graspdsl.notation.greek import LETTERS
from graspdsl.notation.latex import plain

_WORDS = {letter: word for word, letter in LETTERS.items()}
_SHORT = {"g": "γ", "G": "Γ"}

# As in grammar.lark: pieces of letters and digits, joined by "_" or, before a letter, by "__".
_NAME = re.compile(r"(?!\d)[A-Za-zΑ-Ωα-ω0-9]+(?:(?:_|__(?![0-9]))[A-Za-zΑ-Ωα-ω0-9]+)*")
_RUN = re.compile(r"[A-Za-z]+|[Α-Ωα-ω]|[0-9]+|__")
_SUBSCRIPT = re.compile(r"(?<!_)_(?!_)")
_NUMBERED = re.compile(r"[φτσπκγΓ]_[0-9]+")


def canonical(name: str) -> str:
    """The canonical spelling of a name: ``phi_fr`` → φ_fr, ``g1``, ``gamma_1``, ``γ₁`` → γ1, ``G_sigma`` → Γ_σ.

    LaTeX is a spelling, too: ``\\gamma_{23}`` is γ23.

    Text that is no name keeps its words; only its characters are folded. Applying it twice changes nothing.
    """
    folded = plain(name)
    if not _NAME.fullmatch(folded):
        return fold(name)
    segments = _SUBSCRIPT.split(folded)
    spelt = "_".join(_canonical_segment(segment, head=place == 0) for place, segment in enumerate(segments))
    # γ_1 and γ1 are one contact; the chapter prints it with a subscript.
    return spelt.replace("_", "") if _NUMBERED.fullmatch(spelt) else spelt


def ascii_name(name: str) -> str:
    """The ASCII spelling of a canonical name: Γ_m → ``G_m``, π_gθ → ``pi_gtheta``; :func:`canonical` reads it back."""
    return "_".join(_ascii_segment(segment, head=place == 0) for place, segment in enumerate(_SUBSCRIPT.split(name)))


def latex_name(name: str) -> str:
    """The LaTeX spelling of a canonical name: π_gθ → ``\\pi_{g\\theta}``; :func:`canonical` reads it back."""
    head, *rest = _SUBSCRIPT.split(name)
    if _NUMBERED.fullmatch(f"{head[0]}_{head[1:]}") and not rest:
        head, rest = head[0], [head[1:]]
    letters = _latex_segment(head)
    spelt = letters if len(head) == 1 else rf"\mathit{{{letters}}}"
    return f"{spelt}_{{{_latex_segment('_'.join(rest))}}}" if rest else spelt


def _latex_segment(segment: str) -> str:
    """Letters and digits as LaTeX has them; what would run on from a command stands apart."""
    spelt = re.sub(r"[Α-Ωα-ω]", lambda letter: f"\\{_WORDS[letter.group()]} ", segment).replace("_", r"\_")
    return re.sub(r" (?![A-Za-z])", "", spelt)


def _canonical_segment(segment: str, head: bool) -> str:
    runs = _RUN.findall(segment)
    if head and runs[0] in _SHORT and _head_ends(runs):
        runs[0] = _SHORT[runs[0]]
    pieces = [_greek(run, head) for run in runs]
    for place in range(1, len(pieces) - 1):
        # A seam has done its work once a Greek letter stands beside it.
        if pieces[place] == "__" and (pieces[place - 1][-1] in _WORDS or pieces[place + 1][0] in _WORDS):
            pieces[place] = ""
    return "".join(pieces)


def _head_ends(runs: Sequence[str]) -> bool:
    return len(runs) == 1 or runs[1].isdecimal()


def _greek(run: str, head: bool) -> str:
    if run in LETTERS:
        return LETTERS[run]
    if not head and run.endswith("theta"):
        return _greek(run.removesuffix("theta"), head) + "θ"
    return run


def _ascii_segment(segment: str, head: bool) -> str:
    runs = _RUN.findall(segment)
    spelt = ""
    for place, run in enumerate(runs):
        previous = runs[place - 1] if place else ""
        if run not in _WORDS:
            spelt += f"__{run}" if previous in _WORDS and run.isalpha() else run
        elif head and place == 0 and run in _SHORT.values() and _head_ends(runs):
            spelt += "g" if run == "γ" else "G"
        elif previous.isalpha() and not (run == "θ" and previous not in _WORDS and not head):
            spelt += f"__{_WORDS[run]}"
        else:
            spelt += _WORDS[run]
    return spelt
