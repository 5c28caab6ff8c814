"""What potentials, sensor and effector transforms have to keep alike: their names, their sources, what they read."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence

import numpy as np

from graspdsl.arrays import Array
from graspdsl.basis.entry import Entry
from graspdsl.contracts.drawing import READABLE
from graspdsl.contracts.rule import Breach
from graspdsl.diagnostics import listed
from graspdsl.notation.names import ascii_name, canonical
from graspdsl.notation.parser import parse_expression
from graspdsl.notation.printer import to_ascii, to_unicode

UNITS = r"\[[^]]*\b(1|m|N|rad|kg|s)\b[^]]*\]|\bDimensionless\b|\bIn (m|N|rad|J|\(N·m\))[²·]*\b"
# Of what is computed for many trials at once against one at a time: a millionth of a millionth.
SAME, NEXT_TO_NOTHING = 1e-12, 1e-14


def misspelt(entry: Entry, head: str) -> Iterator[Breach]:
    """A symbol is φ_…, σ_… or τ_…, and the same after it was printed and read in Unicode and in ASCII."""
    symbol = entry.symbol
    if not symbol.startswith(f"{head}_"):
        yield f"its symbol is {symbol}", f"begin it with {head}_"
        return
    names = {"φ": "φ_fr", "τ": "τ_fr", "σ": "σ_fr"} | {head: symbol}
    formula = f"{names['φ']}|{names['τ']}(γ1) {names['σ']}(γ1)"
    spellings = {canonical(symbol), canonical(ascii_name(symbol))}
    tree = parse_expression(formula)
    printed = {parse_expression(to_unicode(tree)), parse_expression(to_ascii(tree))}
    if spellings != {symbol} or printed != {tree} or to_unicode(tree) != formula:
        other = next(iter(sorted(spellings - {symbol})), to_unicode(tree))
        yield f"its symbol is {symbol}, which formulas read as {other}", f"call it {canonical(symbol)}"


def misplaced(entry: Entry, table: Mapping[str, Entry]) -> Iterator[Breach]:
    """An entry is found in its table, by its own symbol."""
    if table.get(entry.symbol) is not entry:
        found = type(table[entry.symbol]).__name__ if entry.symbol in table else "nothing"
        yield f"{entry.symbol} names {found} in the table", f"enter it as {ascii_name(entry.symbol)}"


def undocumented(entry: Entry) -> Iterator[Breach]:
    """A docstring begins with the symbol, cites the source as ``equation`` has it, and names the unit."""
    text = " ".join((type(entry).__doc__ or "").split())
    if not text.startswith(entry.symbol):
        yield f"its docstring does not begin with {entry.symbol}", f"write what {entry.symbol} is: its formula"
    if entry.source not in text:
        yield f"its docstring does not name its source, {entry.source}", f"write ({entry.source})"
    if not re.search(UNITS, text):
        yield "its docstring names no unit", "write the unit in brackets, [m], or 'In m².' or 'Dimensionless.'"
    if not entry.about or "\n" in entry.about or entry.about.endswith("."):
        yield f"its line for lists is {entry.about!r}", "write about in one line, without a full stop"


def unreadable(reads: Sequence[str]) -> Iterator[Breach]:
    """What is read is there to be read."""
    for name in reads:
        if name not in READABLE:
            yield f"it reads {name!r}, which there is not", f"read {listed(READABLE, 'or')}"


def not_pure(function: Callable[..., Array], *given: Array) -> Iterator[Breach]:
    """What is given stays as it is, and the same gives the same."""
    before = [value.copy() for value in given]
    first = function(*given).copy()
    if not all(np.array_equal(value, kept) for value, kept in zip(given, before, strict=True)):
        yield "it changes what it is given", "make new arrays: no out=, no +="
    elif not np.array_equal(first, function(*given), equal_nan=True):
        yield "it gives something else for the same numbers", "keep nothing from one call to the next"


def not_one_by_one(whole: Array, each: Iterable[Array]) -> Iterator[Breach]:
    """What comes of many at once is what comes of each by itself, to a relative SAME."""
    alone = np.stack(list(each))
    many = whole.reshape(-1, *whole.shape[2:])
    if many.shape != alone.shape or not np.allclose(many, alone, rtol=SAME, atol=NEXT_TO_NOTHING, equal_nan=True):
        hint = "let leading axes be: count axes from the end, as axis=-1 and '...i' do"
        yield "many trials at once give something else than one by one", hint
