"""Where a key goes that a mapping of a document lacks."""

from __future__ import annotations

from collections.abc import Sequence

from graspdsl.diagnostics import Fix, Span
from graspdsl.places.document import Document, Path
from graspdsl.places.positions import Piece


def key_added(document: Document, path: Path, entry: str, order: Sequence[str]) -> tuple[Fix, ...]:
    """The edit that adds ``entry``, ``key: value`` on one line, at a path: before the first key that comes after it in
    an ``order`` of keys, else behind the last one; first in brackets.

    Nothing for a mapping that has no place of its own in the file, or no keys there.
    """
    around = path[:-1]
    if document.origin(around) is not None or around not in document.places:
        return ()
    piece = document.places[around].value
    if document.is_flow(around):
        return (_inserted(document, piece.start + 1, f"{entry}, " if document.get(around) else entry),)
    keys = _keys(document, around, piece)
    if not keys:
        return ()
    later = order[order.index(str(path[-1])) + 1 :] if path[-1] in order else ()
    following = [key for name, key in keys if name in later]
    column = document.lines.place(keys[0][1].start)[1]
    if following:
        return (_inserted(document, following[0].start, f"{entry}\n{' ' * (column - 1)}"),)
    end = document.text.find("\n", piece.end)
    return (_inserted(document, end if end >= 0 else len(document.text), f"\n{' ' * (column - 1)}{entry}"),)


def _keys(document: Document, around: Path, piece: Piece) -> list[tuple[str, Piece]]:
    """The keys that stand in a mapping itself, in the order of the file; not those that an alias brings in."""
    data = document.get(around)
    names = data if isinstance(data, dict) else {}
    found = [(name, place.key) for name in names if (place := document.places.get((*around, name))) and place.key]
    return sorted(
        ((name, key) for name, key in found if piece.start <= key.start < piece.end), key=lambda each: each[1].start
    )


def _inserted(document: Document, offset: int, text: str) -> Fix:
    line, column = document.lines.place(offset)
    return Fix(Span(line, column, line, column), text)
