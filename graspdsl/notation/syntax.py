"""The Lark parser of the notation, made when a formula is first read; Lark's errors stay in here."""

from __future__ import annotations

import functools
import io
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Literal

from graspdsl.places.kept import kept

if TYPE_CHECKING:
    from collections.abc import Callable

    from lark import Lark, Token, Tree
    from lark.exceptions import UnexpectedInput

TEXT = Path(__file__).with_name("grammar.lark")

# Letters and digits of other alphabets are refused before a text comes here (alphabet.py): what Python takes for them
# says as much as the lists, and compiles in a third of the time.
SHORTER = {"[A-Za-zΑ-Ωα-ω0-9]": r"[^\W_]", "[A-Za-zΑ-Ωα-ω]": r"[^\W\d_]"}

Start = Literal["expression", "head", "resources"]

ROLES = {
    "POTENTIAL": "potential",
    "EFFECTOR": "effector transform",
    "SENSOR": "sensor transform",
    "ABBREVIATION": "abbreviation",
}


@dataclass(frozen=True, slots=True)
class Halt:
    """Where reading came to a halt: offset, word and terminal there (``$END`` at the end, empty for a stray sign).

    ``accepted`` are the terminals that could have stood there; ``owner`` is the φ, τ, σ or π whose part was being read
    and ``role`` its terminal, both empty outside of any.
    """

    at: int
    word: str
    kind: str
    accepted: frozenset[str]
    owner: str
    role: str


@functools.cache
def grammar() -> Lark:
    """The parser for grammar.lark, with the contextual lexer."""
    # Importing Lark takes longer than importing the rest of the notation, and printing does not need it.
    from lark import Lark, __version__

    def tables() -> bytes:
        made, text = io.BytesIO(), TEXT.read_text(encoding="utf-8")
        for listed, short in SHORTER.items():
            text = text.replace(listed, short)
        Lark(
            text,
            parser="lalr",
            lexer="contextual",
            start=["expression", "head", "resources"],
            propagate_positions=True,
            maybe_placeholders=False,
        ).save(made)
        return made.getvalue()

    return Lark.load(io.BytesIO(kept("grammar", __version__, tables)))


def read(folded: str, start: Start) -> Tree[Token] | Halt:
    """Lark's tree of a text with folded characters, or where reading came to a halt."""
    parser = grammar()
    from lark.exceptions import UnexpectedInput

    try:
        return parser.parse(folded, start=start)
    except UnexpectedInput as error:
        return _halt(error, folded)


def _halt(error: UnexpectedInput, folded: str) -> Halt:
    from lark.exceptions import UnexpectedToken

    at = error.pos_in_stream or 0
    word, kind = folded[at : at + 1], ""
    if isinstance(error, UnexpectedToken):
        word, kind = error.token.value, error.token.type
    if kind == "$END":
        at, word = len(folded.rstrip()), ""
    # Lark's own annotation is missing.
    accepts: Callable[[], set[str]] = error.interactive_parser.accepts
    # A parser that has read a whole text accepts nothing, not even the end.
    return Halt(at, word, kind, frozenset(accepts() or {"$END"}), *_owner(error))


def _owner(error: UnexpectedInput) -> tuple[str, str]:
    from lark import Token, Tree

    for value in reversed(error.interactive_parser.parser_state.value_stack):
        # The grammar makes a node of a potential's name as soon as it has seen the bar.
        leaf = value.children[0] if isinstance(value, Tree) and value.data == "potential" else value
        if isinstance(leaf, Token) and leaf.type in ROLES:
            return leaf.value, leaf.type
    return "", ""
